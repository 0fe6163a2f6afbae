#pragma once
#include <algorithm>
#include <array>
#include <impact/input/database.hpp>
#include <impact/input/expression.hpp>
#include <impact/input/spelling.hpp>
#include <impact/input/units.hpp>

/// Text to value and back for one option, with checks and messages; what the rows of the option tables are
/// made of.
namespace impact {

/// Words that stand for a number, such as auto and inf.
using NumberWords = std::vector<std::pair<std::string, double>>;

/// Numbers that an option takes, and words that stand for some.
struct AllowedNumbers {
  AllowedNumbers(const Interval& numbers, NumberWords named = {}) : range(numbers), words(std::move(named)) {}
  AllowedNumbers(double low, double high = unbounded, bool open_low = false, bool open_high = false)
      : range{low, high, open_low, open_high} {}
  Interval range;
  NumberWords words;
};
inline AllowedNumbers or_word(const Interval& range, const std::string& word, double value) {
  return {range, {{word, value}}};
}
inline AllowedNumbers or_auto(const Interval& range) {
  return or_word(range, "auto", std::numeric_limits<double>::quiet_NaN());
}

/// What the conversion of every option needs.
struct OptionContext {
  UnitSystem units;
  ExpressionContext names; ///< of expressions
  MPI_Comm comm = PETSC_COMM_SELF;
};

/// How the text of an option becomes a value and back.
template <class Value> struct OptionKind {
  std::string allowed; ///< choices, kind of text; numbers: what beside `range`
  Interval range;
  /// Throws UserError(usage) `-key "text": reason; allowed: ...`.
  std::function<Value(const GivenOption&, const OptionContext&)> read;
  std::function<std::string(const Value&)> text; ///< "" = absent, nothing to print
};

/// `fallback`: when it is not allowed and no word stands for it, it is the number of an option that is not
/// given.
OptionKind<double> number_kind(const std::string& unit, const AllowedNumbers& allowed, double fallback);
/// A whole number; one below `low` is an option that is not given, which `none` takes back to that.
OptionKind<int> count_kind(int low, int high, int fallback);
OptionKind<bool> flag_kind();
OptionKind<std::string> text_kind(const std::string& allowed);
/// An existing file, resolved (find_input_file).
OptionKind<std::string> file_kind();
/// A comma list of names; of `choices`, where there are some. `may_be_empty`: "none" takes back what an
/// earlier file has put into it, where that is no choice.
OptionKind<std::vector<std::string>> list_kind(const std::vector<std::string>& choices, bool may_be_empty);
/// A comma list of quantities; empty: not given.
OptionKind<std::vector<double>> numbers_kind(const std::string& unit, const Interval& range);
/// A point or direction; two components are enough in plane problems.
OptionKind<std::array<double, 3>> point_kind(const std::string& unit);

/// All of these throw UserError(usage) as OptionKind::read.
double read_number(const GivenOption& option, const std::string& unit, const Interval& range,
                   const NumberWords& words, const UnitSystem& units);
int read_count(const GivenOption& option, int low, int high);
std::string read_choice(const GivenOption& option, const std::vector<std::string>& choices);
/// An expression, or one number with a unit of that kind ("0.5 mm"), which becomes a plain number. A number
/// outside `range` is refused here, an expression where it takes such a value.
Expression read_expression(const GivenOption& option, const std::string& unit, const OptionContext& context,
                           const Interval& range = any_number);

template <class Value>
OptionKind<Value> choice_kind(const std::vector<std::pair<std::string, Value>>& choices) {
  std::vector<std::string> names;
  for (const auto& [word, value] : choices) names.push_back(word);
  const auto read = [=](const GivenOption& option, const OptionContext&) {
    const auto chosen = std::ranges::find(names, read_choice(option, names));
    return choices[static_cast<std::size_t>(chosen - names.begin())].second;
  };
  const auto text = [=](const Value& value) {
    for (const auto& [word, meaning] : choices)
      if (meaning == value) return word;
    return std::string();
  };
  return {join(names), {}, read, text};
}

/// "0 < x <= 1e15 Pa" for the range of a quantity in the run's system; "" when unbounded.
std::string interval_text(const Interval& range, const std::string& unit, const UnitSystem& units);
/// The number, or the word that stands for it.
std::string number_or_word(double value, const NumberWords& words);

/// One line of an options file, "-key value", quoted where PETSc's reader needs it. Such a file cannot hold a
/// double quote or a `#` in a value: an apostrophe and an underscore take their places.
std::string option_line(const std::string& key, const std::string& text);

} // namespace impact

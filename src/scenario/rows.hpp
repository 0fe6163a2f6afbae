#pragma once
#include <algorithm>
#include <functional>
#include <impact/input/option_text.hpp>
#include <impact/input/spelling.hpp>
#include <impact/scenario/restart_keys.hpp>
#include <impact/scenario/scenario.hpp>
#include <optional>

/// The option tables: a row is all that is said of one option. From it come reading, range check, `-help`,
/// reference page, echo, the class at a restart, and what the option demands of others and of the mesh.
namespace impact {

/// What an option row says of itself, in `-help` and in the reference page.
struct OptionNote {
  std::string about;    ///< meaning, one phrase
  std::string unit;     ///< SI unit of a quantity, "1" for a pure number, "" when it is no quantity
  std::string symbol;   ///< in the paper or in src/theory.md
  std::string equation; ///< the paper's equation
  std::string fallback; ///< default as text, that of the struct unless it is said
};

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
inline AllowedNumbers or_auto(const Interval& range) { return or_word(range, "auto", std::nan("")); }

/// One reason to refuse a run. `words` are empty while there is none. In them `<>` stands for the beginning
/// that all options of this id have, as `-contact_tip_`, and `{name}` for the text of the row of that name;
/// `{material}` for the id of the first material.
template <class Struct> struct OptionRule {
  enum class Of {
    absence, ///< the option is not given: `-key: missing; words`
    value,   ///< it is: `-key "text": words`
    key      ///< it is: `-key` and the words at once
  } of;
  std::function<std::string(const Struct&, const Scenario&)> words;
};

template <class Struct> struct OptionRow {
  using Of = typename OptionRule<Struct>::Of;

  std::string name; ///< full name, or the attribute behind -<class>_<id>_; no dash
  OptionNote note;
  Interval range;      ///< of numbers
  std::string allowed; ///< choices, kind of text; numbers: from `range`
  RestartKey restart = RestartKey::guarded;
  std::function<void(Struct&, const GivenOption&, const OptionContext&)> read;
  std::function<std::string(const Struct&)> text; ///< "" = absent, nothing to print
  std::vector<OptionRule<Struct>> rules{};
  /// Of an option that names groups: the dimension that they must have, 0 for any, by that of the mesh.
  std::function<int(const Struct&, int dim)> group_dimension{};
  /// Why the option, which is given, does not fit a mesh of this dimension; "" when it does.
  std::function<std::string(const Struct&, int dim)> misfit{};

  bool given(const Struct& target) const { return text(target) != text(Struct()); }

  OptionRow& otherwise(const std::string& fallback) {
    note.fallback = fallback;
    return *this;
  }
  OptionRow& required() { return otherwise("required"); }
  /// "symbol (equation)", either of them.
  OptionRow& notation(const std::string& said) {
    const std::size_t bracket = said.starts_with("(") ? 0 : said.find(" (");
    note.symbol = said.substr(0, bracket);
    note.equation = bracket == std::string::npos ? "" : said.substr(bracket + (bracket > 0));
    return *this;
  }

  /// The option must be given where `when` holds: a predicate of the struct, or of it and the Scenario.
  /// `words`: a text, or a function with the same arguments.
  template <class When, class Words> OptionRow& needed(When when, Words words) {
    return add(Of::absence, when, words);
  }
  /// The option must not be given, or not with its value, where `when` holds.
  template <class When, class Words> OptionRow& refused(When when, Words words) {
    return add(Of::value, when, words);
  }
  /// As `refused`, but the message goes on where the name of the option ends.
  template <class When, class Words> OptionRow& barred(When when, Words words) {
    return add(Of::key, when, words);
  }

private:
  template <class Function> static auto ask(const Function& f, const Struct& target, const Scenario& all) {
    if constexpr (std::is_invocable_v<Function, const Struct&>)
      return f(target);
    else
      return f(target, all);
  }
  template <class When, class Words> OptionRow& add(Of of, When when, Words words) {
    rules.push_back({of, [=](const Struct& target, const Scenario& all) -> std::string {
                       if (!ask(when, target, all)) return "";
                       if constexpr (std::is_convertible_v<Words, std::string>)
                         return words;
                       else
                         return ask(words, target, all);
                     }});
    return *this;
  }
};

/// In the place of a unit that another option decides.
inline const std::string by_type = "by type";

/// Whether the text of a list takes back what an earlier file had put into it.
inline bool empties(const GivenOption& option, const std::vector<std::string>& choices = {}) {
  return option.text == "none" && std::find(choices.begin(), choices.end(), "none") == choices.end();
}

/// Makes rows and adds them to a list. `part` leads from the struct to what holds the members (nothing: they
/// are its own).
template <class Struct, class Part = std::identity> class Rows {
public:
  using Row = OptionRow<Struct>;

  explicit Rows(std::vector<OptionRow<Struct>>& list, RestartKey restart_class = RestartKey::guarded,
                Part part = {})
      : restart(restart_class), list_(list), part_(part) {}

  RestartKey restart; ///< of the rows from here on

  /// `quantity`: SI unit, symbol and equation, as in "Pa E (52)-(53)". A default that is not allowed stands
  /// for an option that is not given, where no word does.
  template <class Sub>
  Row& number(const std::string& name, double Sub::*place, const std::string& quantity,
              const AllowedNumbers& allowed, const std::string& about) {
    const Interval range = allowed.range;
    NumberWords words = allowed.words;
    const double fallback = at(place)(std::as_const(example_));
    if (words.empty() && !range.contains(fallback)) words = {{"", fallback}};
    return add(
        name, place, quantity, range, words.empty() ? "" : words[0].first, about,
        [=, unit = unit_of(quantity)](double& value, const GivenOption& option,
                                      const OptionContext& context) {
          value = read_number(option, unit, range, words, context.units);
        },
        [=](double value) { return number_or_word(value, words); });
  }

  /// A whole number; one below the range is the struct's way of saying "not given".
  template <class Sub>
  Row& count(const std::string& name, int Sub::*place, int low, int high, const std::string& about) {
    const std::string bounds = high == std::numeric_limits<int>::max()
                                   ? " >= " + std::to_string(low)
                                   : ", " + std::to_string(low) + " to " + std::to_string(high);
    return add(
        name, place, "", {}, "whole number" + bounds, about,
        [=](int& value, const GivenOption& option, const OptionContext&) {
          value = read_count(option, low, high);
        },
        [=](int value) { return value < low ? std::string() : std::to_string(value); });
  }
  template <class Sub>
  Row& count(const std::string& name, int Sub::*place, int low, const std::string& about) {
    return count(name, place, low, std::numeric_limits<int>::max(), about);
  }

  template <class Sub> Row& flag(const std::string& name, bool Sub::*place, const std::string& about) {
    return add(
        name, place, "", {}, "on, off", about,
        [](bool& value, const GivenOption& option, const OptionContext&) { value = read_flag(option); },
        [](bool value) { return value ? "on" : "off"; });
  }

  template <class Sub>
  Row& text(const std::string& name, std::string Sub::*place, const std::string& allowed,
            const std::string& about) {
    return add(
        name, place, "", {}, allowed, about,
        [=](std::string& value, const GivenOption& option, const OptionContext&) {
          if (option.text.empty()) refuse_option(option, "a value is missing; allowed: " + allowed);
          value = option.text;
        },
        std::identity());
  }

  /// An existing file, resolved (find_input_file).
  template <class Sub> Row& file(const std::string& name, std::string Sub::*place, const std::string& about) {
    return add(
        name, place, "", {}, "path of a file", about,
        [](std::string& value, const GivenOption& option, const OptionContext& context) {
          value = find_input_file(context.comm, option);
        },
        std::identity());
  }

  template <class Value> using Choices = std::vector<std::pair<std::string, Value>>;
  template <class Value, class Sub>
  Row& choice(const std::string& name, Value Sub::*place, const std::string& about,
              const std::type_identity_t<Choices<Value>>& choices) {
    std::vector<std::string> names;
    for (const auto& [word, value] : choices) names.push_back(word);
    return add(
        name, place, "", {}, join(names), about,
        [=](Value& value, const GivenOption& option, const OptionContext&) {
          const auto chosen = std::find(names.begin(), names.end(), read_choice(option, names));
          value = choices[static_cast<std::size_t>(chosen - names.begin())].second;
        },
        [=](const Value& value) {
          for (const auto& [word, meaning] : choices)
            if (meaning == value) return word;
          return std::string();
        });
  }
  /// The choices one after the other: word, value, word, value, ..
  template <class Value, class Sub, class... Rest>
  Row& choice(const std::string& name, Value Sub::*place, const std::string& about, const char* word,
              const Rest&... rest) {
    Choices<Value> choices;
    add_choices(choices, word, rest...);
    return choice(name, place, about, choices);
  }

  /// A comma list of names; of `choices`, where there are some.
  template <class Sub>
  Row& list(const std::string& name, std::vector<std::string> Sub::*place, const std::string& about,
            const std::vector<std::string>& choices = {}) {
    return add(
        name, place, "", {}, "comma list of " + (choices.empty() ? "names" : join(choices)), about,
        [=](std::vector<std::string>& value, const GivenOption& option, const OptionContext&) {
          value = empties(option, choices) ? std::vector<std::string>() : read_list(option, choices);
        },
        [](const std::vector<std::string>& value) { return join(value, ","); });
  }

  /// A comma list of groups of the mesh, required; `dimension` as OptionRow::group_dimension.
  template <class Sub, class Dimension>
  Row& groups(const std::string& name, std::vector<std::string> Sub::*place, const std::string& about,
              Dimension dimension) {
    Row& row = list(name, place, about).required();
    row.read = [at = at(place)](Struct& target, const GivenOption& option, const OptionContext&) {
      at(target) = read_list(option, {});
    };
    row.group_dimension = dimension;
    return row;
  }

  /// A comma list of quantities; an empty vector means "not given".
  template <class Sub>
  Row& numbers(const std::string& name, std::vector<double> Sub::*place, const std::string& quantity,
               const Interval& range, const std::string& about) {
    return add(
        name, place, quantity, range, "comma list", about,
        [=, unit = unit_of(quantity)](std::vector<double>& value, const GivenOption& option,
                                      const OptionContext& context) {
          value = empties(option) ? std::vector<double>() : read_numbers(option, unit, range, context.units);
        },
        numbers_text);
  }

  /// A point or direction; two components are enough in plane problems.
  template <class Sub>
  Row& point(const std::string& name, double (Sub::*place)[3], const std::string& quantity,
             const std::string& about) {
    return add(
        name, place, quantity, {}, "x,y or x,y,z", about,
        [unit = unit_of(quantity)](double(&value)[3], const GivenOption& option,
                                   const OptionContext& context) {
          std::vector<double> read = read_numbers(option, unit, any_number, context.units);
          if (read.size() < 2 || read.size() > 3)
            refuse_option(option, "two or three numbers expected; allowed: x,y or x,y,z");
          read.resize(3, 0.);
          std::copy(read.begin(), read.end(), value);
        },
        [](const double(&x)[3]) {
          return numbers_text({x[0], x[1], x[2]});
        });
  }

  /// An expression. Its unit and range may be functions of what has been read before; `quantity` and
  /// `documented` are what the reference says then.
  template <class Place, class UnitOf, class RangeOf>
  Row& expression(const std::string& name, Place place, const std::string& quantity,
                  const Interval& documented, const std::string& about, UnitOf unit, RangeOf range) {
    return add(
        name, std::identity(), quantity, documented, "expression", about,
        [at = at(place), unit, range](Struct& target, const GivenOption& option,
                                      const OptionContext& context) {
          at(target) = read_expression(option, unit(target), context, range(target));
        },
        [at = at(place)](const Struct& target) {
          const std::optional<Expression>& value = at(target);
          return value ? value->text() : std::string();
        });
  }
  template <class Place>
  Row& expression(const std::string& name, Place place, const std::string& quantity, const Interval& range,
                  const std::string& about) {
    return expression(
        name, place, quantity, range, about, [unit = unit_of(quantity)](const Struct&) { return unit; },
        [range](const Struct&) { return range; });
  }

  /// Rows `<stem>x`, `<stem>y`, `<stem>z` of an array of three expressions; a plane mesh takes those in the
  /// plane, or of rotations the one about z.
  enum class Of { places, turns };
  template <class Array, class Sub, class UnitOf>
  void components(const std::string& stem, Array Sub::*place, const std::string& quantity,
                  const std::string& about, UnitOf unit, Of of = Of::places) {
    for (int k = 0; k < 3; ++k) {
      Row& row = expression(
          stem + "xyz"[k], [=](auto& target) -> auto& { return (target.*place)[k]; }, quantity, any_number,
          about, unit, [](const Struct&) { return any_number; });
      if (of == Of::places ? k == 2 : k < 2)
        row.misfit = [=](const Struct&, int dim) {
          return dim == 3 ? std::string()
                          : std::string("the mesh is plane; allowed: ") +
                                (of == Of::turns ? "rz" : "x and y components");
        };
    }
  }
  template <class Array, class Sub>
  void components(const std::string& stem, Array Sub::*place, const std::string& quantity,
                  const std::string& about, Of of = Of::places) {
    components(
        stem, place, quantity, about, [unit = unit_of(quantity)](const Struct&) { return unit; }, of);
  }

private:
  template <class Place> auto at(Place place) const {
    return [ part = part_, place ](auto& target) -> auto& {
      return std::invoke(place, std::invoke(part, target));
    };
  }

  static std::string unit_of(const std::string& quantity) {
    return quantity == by_type ? quantity : quantity.substr(0, quantity.find(' '));
  }

  template <class Value, class... Rest>
  static void add_choices(Choices<Value>& choices, const char* word, const std::type_identity_t<Value>& value,
                          const Rest&... rest) {
    choices.emplace_back(word, value);
    if constexpr (sizeof...(rest) > 0) add_choices(choices, rest...);
  }

  template <class Place, class Read, class Text>
  Row& add(const std::string& name, Place place, const std::string& quantity, const Interval& range,
           const std::string& allowed, const std::string& about, Read set, Text get) {
    Row& row = list_.emplace_back();
    row.name = name;
    row.range = range;
    row.allowed = allowed;
    row.restart = restart;
    row.note.about = about;
    row.note.unit = unit_of(quantity);
    if (quantity != row.note.unit) row.notation(quantity.substr(row.note.unit.size() + 1));
    row.read = [at = at(place), set](Struct& target, const GivenOption& option,
                                     const OptionContext& context) { set(at(target), option, context); };
    row.text = [at = at(place), get](const Struct& target) { return std::string(get(at(target))); };
    return row.otherwise(row.text(example_));
  }

  std::vector<Row>& list_;
  Part part_;
  Struct example_; ///< whose values are the defaults
};

} // namespace impact

#pragma once
#include <impact/input/database.hpp>
#include <impact/input/expression.hpp>
#include <impact/input/interval.hpp>
#include <impact/input/units.hpp>
#include <string>
#include <utility>
#include <vector>

/// Text to value and back for one option, with checks and messages; what the rows of the option tables are
/// made of.
namespace impact {

/// Words that stand for a number, such as auto and inf.
using NumberWords = std::vector<std::pair<std::string, double>>;

/// What the conversion of every option needs.
struct OptionContext {
  UnitSystem units;
  ExpressionContext names; ///< of expressions
  MPI_Comm comm = PETSC_COMM_SELF;
};

/// "0 < x <= 1e15 Pa" for the range of a quantity in the run's system; "" when unbounded.
std::string interval_text(const Interval& range, const std::string& unit, const UnitSystem& units);

/// All of these throw UserError(usage) `-key "text": reason; allowed: ...`.
double read_number(const GivenOption& option, const std::string& unit, const Interval& range,
                   const NumberWords& words, const UnitSystem& units);
int read_count(const GivenOption& option, int low, int high);
bool read_flag(const GivenOption& option);
std::string read_choice(const GivenOption& option, const std::vector<std::string>& choices);
/// A comma list, not empty and without empty or repeated parts; where `choices` is not empty, of these.
std::vector<std::string> read_list(const GivenOption& option, const std::vector<std::string>& choices);
/// A comma list of quantities.
std::vector<double> read_numbers(const GivenOption& option, const std::string& unit, const Interval& range,
                                 const UnitSystem& units);
/// An expression, or one number with a unit of that kind ("0.5 mm"), which becomes a plain number. A number
/// outside `range` is refused here, an expression where it takes such a value.
Expression read_expression(const GivenOption& option, const std::string& unit, const OptionContext& context,
                           const Interval& range = any_number);

/// The number, or the word that stands for it.
std::string number_or_word(double value, const NumberWords& words);
/// Numbers joined by commas.
std::string numbers_text(const std::vector<double>& values);

/// One line of an options file, "-key value", quoted where PETSc's reader needs it. Such a file cannot hold a
/// double quote or a `#` in a value: an apostrophe and an underscore take their places.
std::string option_line(const std::string& key, const std::string& text);

} // namespace impact

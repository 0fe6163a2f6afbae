#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// A scalar expression of x, y, z (reference coordinates) and t, with the user's parameters and tables
/// (muParser).
namespace impact {

/// Range of a number, in SI units; an open end excludes its bound.
struct Interval {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool open_low = false, open_high = false;
  bool contains(double value) const {
    return (open_low ? value > low : value >= low) && (open_high ? value < high : value <= high);
  }
};
inline constexpr double unbounded = std::numeric_limits<double>::infinity();
inline constexpr Interval any_number{};
inline constexpr Interval positive{0, unbounded, true, false};
inline constexpr Interval not_negative{0, unbounded, false, false};
inline constexpr Interval fraction{0, 1, false, false};

/// Piecewise linear function, constant beyond its ends.
struct LinearTable {
  std::vector<double> t, value; ///< t strictly increasing, equally long, not empty
  double operator()(double at) const;
};

/// Reads two columns (t, value) separated by commas, semicolons, blanks or tabs; `#` begins a comment and one
/// header line is skipped. Throws std::invalid_argument with the line and the reason.
LinearTable parse_table(const std::string& csv);

/// Names beside x y z t pi e: parameters with values in run units and tables name(t) from CSV files.
struct ExpressionContext {
  std::vector<std::pair<std::string, double>> parameters; ///< in the order in which messages list them
  std::vector<std::pair<std::string, LinearTable>> tables;
};

/// True for names that no parameter or table may take: variables, constants and functions of the language.
bool reserved_in_expressions(const std::string& name);

class Expression {
public:
  /// Parses `text`; `key` names the option in error messages. `context` is read here only and may be null.
  /// Throws UserError(usage) with the character position (from 0) and the known names; refuses a single `=`.
  /// A value with a unit ("1 mm") is no expression: the option reader converts it to a plain number first.
  /// Functions: those of muParser (sin ... sqrt exp ln log log10 abs sign min max, `a ? b : c`, and or as &&
  /// ||), ramp(t,t0,t1) 0 to 1 linearly, step(t,t0) 1 from t0 on, pulse(t,t0,t1) 1 in [t0,t1),
  /// cycle(t,period) from 0 to 1 in the middle of each period and back to 0, linearly.
  Expression(std::string key, std::string text, const ExpressionContext* context = nullptr);
  /// Takes a function of a reference point, its dimension and time in place of a text; text() is then
  /// "function".
  Expression(std::string key, std::function<double(const double* x, int dim, double t)> function);

  /// From here on values outside `range` are refused like those that are not finite, but for rounding, which
  /// is cut off; `allowed` is the range as text.
  void restrict_to(const Interval& range, const std::string& allowed);

  /// Value at a reference point (`dim` coordinates, the others are 0) and time. Throws UserError(data) naming
  /// option, point and time when it is not finite or out of its range; where ranks evaluate different points,
  /// the caller makes them agree. Copies share one scratch place: one thread for all of them.
  double operator()(const double* x, int dim, double t) const;
  /// Whether the text asks for t.
  bool asks_for_time() const;
  const std::string& key() const;
  const std::string& text() const;
  bool operator==(const Expression& other) const { return text() == other.text(); } ///< of texts only

private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

} // namespace impact

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <impact/input/spelling.hpp>
#include <impact/input/units.hpp>
#include <stdexcept>
#include <utility>

namespace impact {

namespace {

struct NamedUnit {
  std::string_view name;
  Unit unit;
  bool prefixed; // may carry an SI prefix
};

constexpr double degree = 0.017453292519943295;

constexpr std::array<NamedUnit, 18> units = {{
    {"g", {{1, 0, 0, 0}, -3, 1}, true},
    {"t", {{1, 0, 0, 0}, 3, 1}, false},
    {"m", {{0, 1, 0, 0}, 0, 1}, true},
    {"s", {{0, 0, 1, 0}, 0, 1}, true},
    {"min", {{0, 0, 1, 0}, 0, 60}, false},
    {"h", {{0, 0, 1, 0}, 0, 3600}, false},
    {"K", {{0, 0, 0, 1}, 0, 1}, true},
    {"N", {{1, 1, -2, 0}, 0, 1}, true},
    {"Pa", {{1, -1, -2, 0}, 0, 1}, true},
    {"bar", {{1, -1, -2, 0}, 5, 1}, false},
    {"J", {{1, 2, -2, 0}, 0, 1}, true},
    {"W", {{1, 2, -3, 0}, 0, 1}, true},
    {"Hz", {{0, 0, -1, 0}, 0, 1}, true},
    {"rad", {{0, 0, 0, 0}, 0, 1}, false},
    {"deg", {{0, 0, 0, 0}, 0, degree}, false},
    {"%", {{0, 0, 0, 0}, -2, 1}, false},
    {"1", {{0, 0, 0, 0}, 0, 1}, false},
    {"cm", {{0, 1, 0, 0}, -2, 1}, false},
}};

constexpr std::array<std::pair<char, int>, 6> prefixes = {
    {{'n', -9}, {'u', -6}, {'m', -3}, {'k', 3}, {'M', 6}, {'G', 9}}};

/// Every name of a unit in the order of the table, those with a prefix behind the one without.
const std::vector<std::pair<std::string, Unit>>& all_units() {
  static const auto names = [] {
    std::vector<std::pair<std::string, Unit>> all;
    for (const NamedUnit& one : units) {
      all.emplace_back(one.name, one.unit);
      for (const auto& [letter, decade] : prefixes)
        if (one.prefixed)
          all.emplace_back(letter + std::string(one.name),
                           Unit{one.unit.dimension, one.unit.decade + decade, one.unit.factor});
    }
    return all;
  }();
  return names;
}

/// Units that differ from the name in capitals alone: "Gpa".
std::string other_capitals(std::string_view name) {
  std::string found;
  for (const auto& [unit, meaning] : all_units())
    if (lower_case(unit) == lower_case(name)) found += (found.empty() ? "; did you mean " : " or ") + unit;
  return found.empty() ? found : found + "?";
}

/// `first` times `second` to the power `exponent`.
Unit multiply(const Unit& first, const Unit& second, int exponent) {
  const Dimension &a = first.dimension, &b = second.dimension;
  return {{a.mass + exponent * b.mass, a.length + exponent * b.length, a.time + exponent * b.time,
           a.temperature + exponent * b.temperature},
          first.decade + exponent * second.decade,
          first.factor * std::pow(second.factor, exponent)};
}

class UnitParser {
public:
  explicit UnitParser(std::string_view text) : text_(text) {}

  Unit whole() {
    const Unit unit = product(0);
    if (at_ < text_.size()) fail("unexpected '" + std::string(1, text_[at_]) + "'");
    return unit;
  }

private:
  // A level holds 'a.b/c': once divided, a further factor needs brackets, since a/b.c is read in two ways.
  Unit product(int depth) {
    Unit unit = power(depth);
    for (bool divided = false;;) {
      const bool blank = skip_blanks();
      if (at_ == text_.size() || text_[at_] == ')') return unit;
      if (take('/')) {
        divided = true;
        unit = multiply(unit, power(depth), -1);
        continue;
      }
      if (!take('.') && !take('*') && !blank) fail("unexpected '" + std::string(1, text_[at_]) + "'");
      if (divided) fail("put a product below the line into brackets, as in m^2/(N.s)");
      unit = multiply(unit, power(depth), 1);
    }
  }

  Unit power(int depth) {
    skip_blanks();
    const Unit base = factor(depth);
    if (!take('^')) return base;
    int exponent = 0;
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), exponent);
    if (error != std::errc() || std::abs(exponent) > 9)
      fail("an exponent must be a whole number from -9 to 9");
    at_ += static_cast<std::size_t>(end - begin);
    return multiply({}, base, exponent);
  }

  Unit factor(int depth) {
    if (take('(')) {
      if (depth > 8) fail("too many brackets");
      const Unit inner = product(depth + 1);
      if (!take(')')) fail("')' is missing");
      return inner;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && (std::isalpha(static_cast<unsigned char>(text_[at_])) || text_[at_] == '%'))
      ++at_;
    if (at_ == begin) take('1');
    const std::string_view name = text_.substr(begin, at_ - begin);
    if (name.empty()) fail("a unit is missing");
    const auto found =
        std::ranges::find_if(all_units(), [&](const auto& unit) { return unit.first == name; });
    if (found != all_units().end()) return found->second;
    fail("unknown unit '" + std::string(name) + "'" + other_capitals(name));
  }

  bool take(char c) {
    const bool there = at_ < text_.size() && text_[at_] == c;
    if (there) ++at_;
    return there;
  }
  bool skip_blanks() {
    const bool any = take(' ');
    while (take(' ')) {
    }
    return any;
  }

  [[noreturn]] static void fail(const std::string& reason) { throw std::invalid_argument(reason); }

  std::string_view text_;
  std::size_t at_ = 0;
};

/// Number of characters of the decimal number that `text` begins with, 0 for none; `mantissa` excludes the
/// exponent.
std::size_t number_length(std::string_view text, std::size_t& mantissa) {
  const std::size_t sign = text.starts_with('+') || text.starts_with('-') ? 1 : 0;
  if (text.find_first_of(".0123456789") != sign) return 0; // neither inf nor nan
  double value = 0;
  const auto [end, error] = std::from_chars(text.data() + sign, text.data() + text.size(), value);
  if (error == std::errc::invalid_argument) return 0;
  const auto length = static_cast<std::size_t>(end - text.data());
  mantissa = std::min(text.find_first_of("eE"), length);
  return length;
}

std::string base_power(const std::string& name, int exponent) {
  return exponent == 1 ? name : name + "^" + std::to_string(exponent);
}

/// Symbol by a named unit in the multiple that the system has: "MPa", "N/mm", "Pa.s"; empty when there is
/// none.
std::string derived_symbol(const Dimension& dimension, const UnitSystem& system, const std::string& length,
                           const std::string& time) {
  for (int times = 0; times <= 1; ++times) {
    for (int lengths = 0; lengths <= 3; ++lengths) {
      const Dimension core{dimension.mass, dimension.length + lengths, dimension.time - times,
                           dimension.temperature};
      for (const char* name : {"N", "Pa", "J", "W", "K"}) {
        for (const char* prefix : {"", "k", "M", "G", "m", "u"}) {
          const Unit unit = parse_unit(std::string(prefix) + name);
          if (unit.dimension != core || unit.decade != system.decade(core)) continue;
          return prefix + (name + (times ? "." + time : "")) +
                 (lengths ? "/" + base_power(length, lengths) : "");
        }
      }
    }
  }
  return "";
}

double convert(const Literal& literal, const Unit& unit, const UnitSystem& system) {
  const auto value = parse_number(literal.number, unit.decade - system.decade(unit.dimension));
  const double converted = value.value_or(HUGE_VAL) * unit.factor;
  if (!std::isfinite(converted)) throw std::invalid_argument("not a number that a double can hold");
  return converted;
}

} // namespace

int UnitSystem::decade(const Dimension& d) const { return d.mass * mass + d.length * length + d.time * time; }

std::optional<UnitSystem> unit_system(std::string_view name) {
  if (name == "SI") return UnitSystem{"SI", 0, 0, 0};
  if (name == "mm_t_s_MPa") return UnitSystem{"mm_t_s_MPa", 3, -3, 0};
  if (name == "mm_kg_ms_GPa") return UnitSystem{"mm_kg_ms_GPa", 0, -3, -3};
  return {};
}

Unit parse_unit(std::string_view text) { return UnitParser(trim(text)).whole(); }

std::optional<double> parse_number(std::string_view text, int decade) {
  text = trim(text);
  std::size_t mantissa = 0;
  if (text.empty() || number_length(text, mantissa) != text.size()) return {};
  if (text.front() == '+') {
    text.remove_prefix(1);
    --mantissa;
  }
  long exponent = 0;
  if (mantissa < text.size()) {
    std::string_view tail = text.substr(mantissa + 1);
    if (tail.front() == '+') tail.remove_prefix(1);
    if (std::from_chars(tail.data(), tail.data() + tail.size(), exponent).ec != std::errc()) return {};
  }
  const std::string shifted = std::string(text.substr(0, mantissa)) + "e" + std::to_string(exponent + decade);
  double value = 0;
  const auto [end, error] = std::from_chars(shifted.data(), shifted.data() + shifted.size(), value);
  if (error != std::errc() || end != shifted.data() + shifted.size()) return {};
  return value;
}

std::optional<Literal> split_literal(std::string_view text) {
  text = trim(text);
  std::size_t mantissa = 0;
  const std::size_t length = number_length(text, mantissa);
  if (length == 0) return {};
  return Literal{text.substr(0, length), trim(text.substr(length))};
}

namespace {

// "(-1)" as "-1": what begins with a minus needs brackets, or PETSc takes it for an option.
std::string_view without_brackets(std::string_view text) {
  text = trim(text);
  const bool enclosed = text.size() > 2 && text.front() == '(' &&
                        text.find_first_of("()", 1) + 1 == text.size() && text.back() == ')';
  return enclosed ? text.substr(1, text.size() - 2) : text;
}

} // namespace

double parse_quantity(std::string_view text, const Dimension& dimension, const UnitSystem& system) {
  text = without_brackets(text);
  const std::string own = unit_symbol(dimension, system);
  const std::string allowed = own == "1" ? std::string("a number without a unit")
                                         : "a number in " + own + ", or one with a unit of that kind";
  const auto literal = split_literal(text);
  if (!literal) throw std::invalid_argument("not a number; allowed: " + allowed);
  if (literal->unit.empty()) return convert(*literal, {dimension, system.decade(dimension), 1}, system);
  Unit unit;
  try {
    unit = parse_unit(literal->unit);
  } catch (const std::invalid_argument& reason) {
    throw std::invalid_argument(reason.what() + ("; allowed: " + allowed));
  }
  if (unit.dimension != dimension)
    throw std::invalid_argument("'" + std::string(literal->unit) +
                                "' has the wrong dimension; allowed: " + allowed);
  return convert(*literal, unit, system);
}

double parse_any_quantity(std::string_view text, const UnitSystem& system) {
  text = without_brackets(text);
  const auto literal = split_literal(text);
  if (!literal) throw std::invalid_argument("not a number; allowed: a number, alone or with a unit");
  const Unit unit = literal->unit.empty() ? Unit{} : parse_unit(literal->unit);
  return convert(*literal, unit, system);
}

std::string unit_symbol(const Dimension& dimension, const UnitSystem& system) {
  const std::string length = system.length == -3 ? "mm" : "m", time = system.time == -3 ? "ms" : "s";
  if (const std::string symbol = derived_symbol(dimension, system, length, time); !symbol.empty())
    return symbol;
  const Dimension inverse = multiply({}, {dimension}, -1).dimension;
  if (const std::string symbol = derived_symbol(inverse, system, length, time); !symbol.empty())
    return symbol.find_first_of("./") == std::string::npos ? "1/" + symbol : "1/(" + symbol + ")";
  std::string above, below;
  int factors_below = 0;
  const std::pair<std::string, int> bases[] = {{system.mass == 3 ? "t" : "kg", dimension.mass},
                                               {length, dimension.length},
                                               {time, dimension.time},
                                               {"K", dimension.temperature}};
  for (const auto& [name, exponent] : bases) {
    if (exponent > 0) above += (above.empty() ? "" : ".") + base_power(name, exponent);
    if (exponent < 0) {
      below += (below.empty() ? "" : ".") + base_power(name, -exponent);
      ++factors_below;
    }
  }
  if (above.empty()) above = "1";
  if (below.empty()) return above;
  return above + "/" + (factors_below > 1 ? "(" + below + ")" : below);
}

std::string number_text(double value) {
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

} // namespace impact

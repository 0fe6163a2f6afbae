#include <algorithm>
#include <charconv>
#include <cmath>
#include <impact/input/option_text.hpp>
#include <impact/input/spelling.hpp>
#include <stdexcept>

namespace impact {

namespace {

std::string quantity_unit(const std::string& unit, const UnitSystem& units) {
  const std::string symbol = unit.empty() ? "1" : unit_symbol(parse_unit(unit).dimension, units);
  return symbol == "1" ? "" : " " + symbol;
}

/// A bound given in SI, in the run's system; through text, so that powers of ten stay exact.
double scaled(double bound, const Dimension& dimension, const UnitSystem& units) {
  if (bound == 0 || !std::isfinite(bound)) return bound;
  return *parse_number(number_text(bound), -units.decade(dimension));
}

std::string suggestion(const std::string& text, const std::vector<std::string>& choices) {
  const std::string near = nearest_name(text, choices, text.size() > 4 ? 2 : 1);
  return near.empty() ? "" : "; did you mean " + near + "?";
}

bool needs_quotes(const std::string& text) {
  if (text.empty() || text.front() == '-') return true;
  return text.find_first_of(" \t\"'[]{}|<>&!%@`?:") != std::string::npos;
}

} // namespace

std::string interval_text(const Interval& range, const std::string& unit, const UnitSystem& units) {
  const Dimension dimension = unit.empty() ? Dimension{} : parse_unit(unit).dimension;
  std::string text;
  const double low = scaled(range.low, dimension, units), high = scaled(range.high, dimension, units);
  if (std::isfinite(low) && std::isfinite(high))
    text = number_text(low) + (range.open_low ? " < value " : " <= value ") +
           (range.open_high ? "< " : "<= ") + number_text(high);
  else if (std::isfinite(low))
    text = (range.open_low ? "> " : ">= ") + number_text(low);
  else if (std::isfinite(high))
    text = (range.open_high ? "< " : "<= ") + number_text(high);
  return text.empty() ? text : text + quantity_unit(unit, units);
}

double read_number(const GivenOption& option, const std::string& unit, const Interval& range,
                   const NumberWords& words, const UnitSystem& units) {
  if (option.text.empty()) refuse_option(option, "a value is missing; allowed: a number");
  std::string other;
  for (const auto& [word, value] : words) {
    if (word.empty()) continue;
    if (option.text == word) return value;
    other += ", or " + word;
  }
  const Dimension dimension = unit.empty() ? Dimension{} : parse_unit(unit).dimension;
  double value = 0;
  try {
    value = parse_quantity(option.text, dimension, units);
  } catch (const std::invalid_argument& reason) {
    refuse_option(option, reason.what() + other);
  }
  const Interval in_run{scaled(range.low, dimension, units), scaled(range.high, dimension, units),
                        range.open_low, range.open_high};
  if (!in_run.contains(value))
    refuse_option(option, "out of range; allowed: " + interval_text(range, unit, units) + other);
  return value;
}

int read_count(const GivenOption& option, int low, int high) {
  int value = 0;
  const char* end = option.text.data() + option.text.size();
  const auto [stop, error] = std::from_chars(option.text.data(), end, value);
  const std::string allowed =
      high == std::numeric_limits<int>::max()
          ? "a whole number >= " + std::to_string(low)
          : "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  if (error != std::errc() || stop != end || option.text.empty())
    refuse_option(option, "not a whole number; allowed: " + allowed);
  if (value < low || value > high) refuse_option(option, "out of range; allowed: " + allowed);
  return value;
}

bool read_flag(const GivenOption& option) {
  const std::string text = lower_case(option.text);
  for (const char* yes : {"", "on", "true", "yes", "1"})
    if (text == yes) return true;
  for (const char* no : {"off", "false", "no", "0"})
    if (text == no) return false;
  refuse_option(option, "not a switch; allowed: on, off");
}

std::string read_choice(const GivenOption& option, const std::vector<std::string>& choices) {
  if (std::find(choices.begin(), choices.end(), option.text) != choices.end()) return option.text;
  refuse_option(option, "not available; allowed: " + join(choices) + suggestion(option.text, choices));
}

std::vector<std::string> read_list(const GivenOption& option, const std::vector<std::string>& choices) {
  const std::vector<std::string> parts = split_list(option.text);
  if (parts.empty()) refuse_option(option, "a value is missing; allowed: a comma list");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].empty()) refuse_option(option, "an empty name between commas; allowed: a comma list");
    if (std::find(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(i), parts[i]) !=
        parts.begin() + static_cast<std::ptrdiff_t>(i))
      refuse_option(option, "'" + parts[i] + "' is given twice; name each once");
    if (!choices.empty() && std::find(choices.begin(), choices.end(), parts[i]) == choices.end())
      refuse_option(option, "'" + parts[i] + "' is not available; allowed: " + join(choices) +
                                suggestion(parts[i], choices));
  }
  return parts;
}

std::vector<double> read_numbers(const GivenOption& option, const std::string& unit, const Interval& range,
                                 const UnitSystem& units) {
  std::vector<double> values;
  for (const std::string& part : split_list(option.text)) {
    if (part.empty())
      refuse_option(option, "an empty place between commas; allowed: a comma list of numbers");
    try {
      values.push_back(parse_quantity(part, parse_unit(unit).dimension, units));
    } catch (const std::invalid_argument& reason) {
      refuse_option(option, "'" + part + "': " + reason.what());
    }
    read_number({option.key, part}, unit, range, {}, units);
  }
  if (values.empty()) refuse_option(option, "a value is missing; allowed: a comma list of numbers");
  return values;
}

Expression read_expression(const GivenOption& option, const std::string& unit, const OptionContext& context,
                           const Interval& range) {
  if (option.text.empty())
    refuse_option(
        option,
        "a value is missing (one that begins with a minus needs brackets: (-t)); allowed: an expression");
  std::string text = option.text;
  const std::string allowed = interval_text(range, unit, context.units);
  if (const auto literal = split_literal(text); literal && !(literal->unit.empty() && allowed.empty())) {
    bool is_unit = true;
    try {
      parse_unit(literal->unit.empty() ? "1" : literal->unit);
    } catch (const std::invalid_argument&) {
      is_unit = false; // an operator or a name: the expression parser says what is wrong
    }
    if (is_unit) text = number_text(read_number(option, unit, range, {}, context.units));
  }
  Expression expression(option.key, text, &context.names);
  if (!allowed.empty()) expression.restrict_to(range, allowed);
  return expression;
}

std::string number_or_word(double value, const NumberWords& words) {
  for (const auto& [word, meaning] : words)
    if (value == meaning || (std::isnan(value) && std::isnan(meaning))) return word;
  return number_text(value);
}

std::string numbers_text(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ",") + number_text(value);
  return text;
}

std::string option_line(const std::string& key, const std::string& text) {
  if (!needs_quotes(text) && text.find('#') == std::string::npos) return "-" + key + " " + text + "\n";
  std::string inner = text;
  std::replace(inner.begin(), inner.end(), '"', '\'');
  std::replace(inner.begin(), inner.end(), '#', '_');
  // PETSc takes "-t" for an option even between quotes; a blank before the minus keeps it a value.
  return "-" + key + (inner.front() == '-' ? " \" " : " \"") + inner + "\"\n";
}

} // namespace impact

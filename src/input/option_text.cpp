#include <algorithm>
#include <charconv>
#include <cmath>
#include <impact/input/option_text.hpp>
#include <stdexcept>

namespace impact {

namespace {

Dimension dimension_of(const std::string& unit) {
  return unit.empty() ? Dimension{} : parse_unit(unit).dimension;
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

bool is_among(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// A comma list, not empty and without empty or repeated parts; where `choices` is not empty, of these.
std::vector<std::string> read_list(const GivenOption& option, const std::vector<std::string>& choices) {
  std::vector<std::string> parts;
  for (const std::string& part : split_list(option.text)) {
    if (part.empty()) refuse_option(option, "an empty name between commas; allowed: a comma list");
    if (is_among(parts, part)) refuse_option(option, "'" + part + "' is given twice; name each once");
    if (!choices.empty() && !is_among(choices, part))
      refuse_option(option,
                    "'" + part + "' is not available; allowed: " + join(choices) + suggestion(part, choices));
    parts.push_back(part);
  }
  if (parts.empty()) refuse_option(option, "a value is missing; allowed: a comma list");
  return parts;
}

std::vector<double> read_numbers(const GivenOption& option, const std::string& unit, const Interval& range,
                                 const UnitSystem& units) {
  std::vector<double> values;
  for (const std::string& part : split_list(option.text)) {
    if (part.empty())
      refuse_option(option, "an empty place between commas; allowed: a comma list of numbers");
    try {
      values.push_back(parse_quantity(part, dimension_of(unit), units));
    } catch (const std::invalid_argument& reason) {
      refuse_option(option, "'" + part + "': " + reason.what());
    }
    read_number({option.key, part}, unit, range, {}, units);
  }
  if (values.empty()) refuse_option(option, "a value is missing; allowed: a comma list of numbers");
  return values;
}

std::string numbers_text(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(number_text(value));
  return join(texts, ",");
}

bool read_flag(const GivenOption& option, const OptionContext&) {
  const std::string text = lower_case(option.text);
  if (is_among({"", "on", "true", "yes", "1"}, text)) return true;
  if (is_among({"off", "false", "no", "0"}, text)) return false;
  refuse_option(option, "not a switch; allowed: on, off");
}

/// ">= 1" or ", 1 to 5", `before` the second form another beginning.
std::string bounds_text(int low, int high, const std::string& before) {
  return high == std::numeric_limits<int>::max()
             ? " >= " + std::to_string(low)
             : before + std::to_string(low) + " to " + std::to_string(high);
}

} // namespace

std::string interval_text(const Interval& range, const std::string& unit, const UnitSystem& units) {
  const Dimension dimension = dimension_of(unit);
  std::string text;
  const double low = scaled(range.low, dimension, units), high = scaled(range.high, dimension, units);
  if (std::isfinite(low) && std::isfinite(high))
    text = number_text(low) + (range.open_low ? " < value " : " <= value ") +
           (range.open_high ? "< " : "<= ") + number_text(high);
  else if (std::isfinite(low))
    text = (range.open_low ? "> " : ">= ") + number_text(low);
  else if (std::isfinite(high))
    text = (range.open_high ? "< " : "<= ") + number_text(high);
  const std::string symbol = unit_symbol(dimension, units);
  return text.empty() || symbol == "1" ? text : text + " " + symbol;
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
  const Dimension dimension = dimension_of(unit);
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
  const std::string allowed = "a whole number" + bounds_text(low, high, " from ");
  if (error != std::errc() || stop != end || option.text.empty())
    refuse_option(option, "not a whole number; allowed: " + allowed);
  if (value < low || value > high) refuse_option(option, "out of range; allowed: " + allowed);
  return value;
}

std::string read_choice(const GivenOption& option, const std::vector<std::string>& choices) {
  if (is_among(choices, option.text)) return option.text;
  refuse_option(option, "not available; allowed: " + join(choices) + suggestion(option.text, choices));
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

OptionKind<double> number_kind(const std::string& unit, const AllowedNumbers& allowed, double fallback) {
  const Interval range = allowed.range;
  NumberWords words = allowed.words;
  const bool may_be_absent = words.empty() && !range.contains(fallback);
  if (may_be_absent) words = {{"", fallback}};
  const auto read = [=](const GivenOption& option, const OptionContext& context) {
    if (may_be_absent && option.text == "none") return fallback; // takes back what a file asks for
    return read_number(option, unit, range, words, context.units);
  };
  return {words.empty() ? "" : words[0].first, range, read,
          [=](double value) { return number_or_word(value, words); }};
}

OptionKind<int> count_kind(int low, int high, int fallback) {
  const auto read = [=](const GivenOption& option, const OptionContext&) {
    return fallback < low && option.text == "none" ? fallback : read_count(option, low, high);
  };
  return {"whole number" + bounds_text(low, high, ", "), {}, read, [=](int value) {
            return value < low ? "" : std::to_string(value);
          }};
}

OptionKind<bool> flag_kind() {
  return {"on, off", {}, read_flag, [](bool value) { return value ? "on" : "off"; }};
}

OptionKind<std::string> text_kind(const std::string& allowed) {
  const auto read = [=](const GivenOption& option, const OptionContext&) {
    if (option.text.empty()) refuse_option(option, "a value is missing; allowed: " + allowed);
    return option.text;
  };
  return {allowed, {}, read, std::identity()};
}

OptionKind<std::string> file_kind() {
  const auto read = [](const GivenOption& option, const OptionContext& context) {
    return find_input_file(context.comm, option);
  };
  return {"path of a file", {}, read, std::identity()};
}

OptionKind<std::vector<std::string>> list_kind(const std::vector<std::string>& choices, bool may_be_empty) {
  const auto read = [=](const GivenOption& option, const OptionContext&) {
    const bool empties = may_be_empty && option.text == "none" && !is_among(choices, "none");
    return empties ? std::vector<std::string>() : read_list(option, choices);
  };
  return {"comma list of " + (choices.empty() ? "names" : join(choices)),
          {},
          read,
          [](const std::vector<std::string>& value) { return join(value, ","); }};
}

OptionKind<std::vector<double>> numbers_kind(const std::string& unit, const Interval& range) {
  const auto read = [=](const GivenOption& option, const OptionContext& context) {
    return option.text == "none" ? std::vector<double>() : read_numbers(option, unit, range, context.units);
  };
  return {"comma list", range, read, numbers_text};
}

OptionKind<std::array<double, 3>> point_kind(const std::string& unit) {
  const auto read = [=](const GivenOption& option, const OptionContext& context) {
    const std::vector<double> x = read_numbers(option, unit, any_number, context.units);
    if (x.size() < 2 || x.size() > 3)
      refuse_option(option, "two or three numbers expected; allowed: x,y or x,y,z");
    return std::array{x[0], x[1], x.size() > 2 ? x[2] : 0};
  };
  return {"x,y or x,y,z", {}, read, [](const auto& x) { return numbers_text({x[0], x[1], x[2]}); }};
}

std::string option_line(const std::string& key, const std::string& text) {
  if (!needs_quotes(text) && text.find('#') == std::string::npos) return "-" + key + " " + text + "\n";
  std::string inner = text;
  std::ranges::replace(inner, '"', '\'');
  std::ranges::replace(inner, '#', '_');
  // PETSc takes "-t" for an option even between quotes; a blank before the minus keeps it a value.
  return "-" + key + (inner.front() == '-' ? " \" " : " \"") + inner + "\"\n";
}

} // namespace impact

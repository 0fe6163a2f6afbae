#pragma once
#include <algorithm>
#include <functional>
#include <impact/input/option_text.hpp>
#include <impact/input/spelling.hpp>
#include <optional>

/// The option table: one row per option, from which come reading, range check, `-help`, reference page and
/// echo. A row is made by one of the functions below from the option's name, the place of its value (a member
/// pointer or a function `auto& (auto& struct)`) and what is said of it.
namespace impact {

template <class Struct> struct OptionRow {
  std::string name; ///< full name, or the attribute behind -<class>_<id>_; no dash
  OptionNote note;
  Interval range;      ///< of numbers
  std::string allowed; ///< choices, kind of text; numbers: from `range`
  std::function<void(Struct&, const GivenOption&, const OptionContext&)> read;
  std::function<std::string(const Struct&)> text; ///< "" = absent, nothing to print
};

/// Reads all rows that `given` has; `given` maps a row's name to what the user typed.
template <class Struct, class Given>
void read_rows(const std::vector<OptionRow<Struct>>& rows, Struct& target, const OptionContext& context,
               const Given& given) {
  for (const OptionRow<Struct>& row : rows)
    if (const std::optional<GivenOption> option = given(row.name)) row.read(target, *option, context);
}

/// The lines of an options file that give `target` again.
template <class Struct>
std::string rows_text(const std::vector<OptionRow<Struct>>& rows, const Struct& target,
                      const std::string& prefix) {
  std::string lines;
  for (const OptionRow<Struct>& row : rows)
    if (const std::string text = row.text(target); !text.empty())
      lines += option_line(prefix + row.name, text);
  return lines;
}

template <class Struct, class Place>
OptionRow<Struct> number_row(const std::string& name, Place place, const OptionNote& note,
                             const Interval& range, const NumberWords& words = {}) {
  std::string special;
  for (const auto& [word, value] : words) special += (special.empty() ? "" : ", ") + word;
  return {name,
          note,
          range,
          special,
          [=](Struct& target, const GivenOption& option, const OptionContext& context) {
            std::invoke(place, target) = read_number(option, note.unit, range, words, context.units);
          },
          [=](const Struct& target) { return number_or_word(std::invoke(place, target), words); }};
}

template <class Struct, class Place>
OptionRow<Struct> count_row(const std::string& name, Place place, const OptionNote& note, int low,
                            int high = std::numeric_limits<int>::max()) {
  const std::string allowed = high == std::numeric_limits<int>::max()
                                  ? "whole number >= " + std::to_string(low)
                                  : "whole number, " + std::to_string(low) + " to " + std::to_string(high);
  return {name,
          note,
          {},
          allowed,
          [=](Struct& target, const GivenOption& option, const OptionContext&) {
            std::invoke(place, target) = read_count(option, low, high);
          },
          // A value below the range is the struct's way of saying "not given".
          [=](const Struct& target) {
            const int value = std::invoke(place, target);
            return value < low ? std::string() : std::to_string(value);
          }};
}

template <class Struct, class Place>
OptionRow<Struct> flag_row(const std::string& name, Place place, const OptionNote& note) {
  return {name,
          note,
          {},
          "on, off",
          [=](Struct& target, const GivenOption& option, const OptionContext&) {
            std::invoke(place, target) = read_flag(option);
          },
          [=](const Struct& target) { return std::string(std::invoke(place, target) ? "on" : "off"); }};
}

template <class Struct, class Place>
OptionRow<Struct> text_row(const std::string& name, Place place, const OptionNote& note,
                           const std::string& allowed) {
  return {name,
          note,
          {},
          allowed,
          [=](Struct& target, const GivenOption& option, const OptionContext&) {
            if (option.text.empty()) refuse_option(option, "a value is missing; allowed: " + allowed);
            std::invoke(place, target) = option.text;
          },
          [=](const Struct& target) { return std::string(std::invoke(place, target)); }};
}

/// An existing file, resolved (find_input_file).
template <class Struct, class Place>
OptionRow<Struct> file_row(const std::string& name, Place place, const OptionNote& note) {
  return {name,
          note,
          {},
          "path of a file",
          [=](Struct& target, const GivenOption& option, const OptionContext& context) {
            std::invoke(place, target) = find_input_file(context.comm, option);
          },
          [=](const Struct& target) { return std::string(std::invoke(place, target)); }};
}

template <class Struct, class Value, class Place>
OptionRow<Struct> choice_row(const std::string& name, Place place, const OptionNote& note,
                             const std::vector<std::pair<std::string, Value>>& choices) {
  std::vector<std::string> names;
  for (const auto& [word, value] : choices) names.push_back(word);
  return {name,
          note,
          {},
          join(names),
          [=](Struct& target, const GivenOption& option, const OptionContext&) {
            const auto chosen = std::find(names.begin(), names.end(), read_choice(option, names));
            std::invoke(place, target) = choices[static_cast<std::size_t>(chosen - names.begin())].second;
          },
          [=](const Struct& target) {
            for (const auto& [word, value] : choices)
              if (value == std::invoke(place, target)) return word;
            return std::string();
          }};
}

/// Whether the text of a list takes back what an earlier file had put into it.
inline bool empties(const GivenOption& option, const OptionNote& note = {},
                    const std::vector<std::string>& choices = {}) {
  return option.text == "none" && note.fallback != "required" &&
         std::find(choices.begin(), choices.end(), option.text) == choices.end();
}

/// A comma list of names; of `choices`, where there are some.
template <class Struct, class Place>
OptionRow<Struct> list_row(const std::string& name, Place place, const OptionNote& note,
                           const std::vector<std::string>& choices = {}) {
  return {name,
          note,
          {},
          choices.empty() ? "comma list of names" : "comma list of " + join(choices),
          [=](Struct& target, const GivenOption& option, const OptionContext&) {
            std::invoke(place, target) =
                empties(option, note, choices) ? std::vector<std::string>() : read_list(option, choices);
          },
          [=](const Struct& target) {
            std::string list;
            for (const std::string& part : std::invoke(place, target))
              list += (list.empty() ? "" : ",") + part;
            return list;
          }};
}

/// A comma list of quantities; an empty vector means "not given".
template <class Struct, class Place>
OptionRow<Struct> numbers_row(const std::string& name, Place place, const OptionNote& note,
                              const Interval& range) {
  return {name,
          note,
          range,
          "comma list",
          [=](Struct& target, const GivenOption& option, const OptionContext& context) {
            std::invoke(place, target) = empties(option)
                                             ? std::vector<double>()
                                             : read_numbers(option, note.unit, range, context.units);
          },
          [=](const Struct& target) { return numbers_text(std::invoke(place, target)); }};
}

/// A point or direction, double[3]; two components are enough in plane problems.
template <class Struct, class Place>
OptionRow<Struct> point_row(const std::string& name, Place place, const OptionNote& note) {
  return {name,
          note,
          {},
          "x,y or x,y,z",
          [=](Struct& target, const GivenOption& option, const OptionContext& context) {
            std::vector<double> read = read_numbers(option, note.unit, any_number, context.units);
            if (read.size() < 2 || read.size() > 3)
              refuse_option(option, "two or three numbers expected; allowed: x,y or x,y,z");
            read.resize(3, 0.);
            std::copy(read.begin(), read.end(), std::invoke(place, target));
          },
          [=](const Struct& target) {
            const double* x = std::invoke(place, target);
            return numbers_text({x[0], x[1], x[2]});
          }};
}

/// An expression in an std::optional; its unit may depend on what has been read before: `unit(struct)`, and
/// so may its range.
template <class Struct, class Place, class UnitOf, class RangeOf>
OptionRow<Struct> expression_row(const std::string& name, Place place, const OptionNote& note, UnitOf unit,
                                 const Interval& documented, RangeOf range) {
  return {name,
          note,
          documented,
          "expression",
          [=](Struct& target, const GivenOption& option, const OptionContext& context) {
            std::invoke(place, target) =
                read_expression(option, unit(std::as_const(target)), context, range(std::as_const(target)));
          },
          [=](const Struct& target) {
            const std::optional<Expression>& expression = std::invoke(place, target);
            return expression ? expression->text() : std::string();
          }};
}

template <class Struct, class Place, class UnitOf>
OptionRow<Struct> expression_row(const std::string& name, Place place, const OptionNote& note, UnitOf unit,
                                 const Interval& range = any_number) {
  return expression_row<Struct>(name, place, note, unit, range, [=](const Struct&) { return range; });
}

} // namespace impact

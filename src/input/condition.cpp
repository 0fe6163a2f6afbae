#include "language.hpp"
#include <algorithm>
#include <cmath>
#include <impact/input/condition.hpp>
#include <impact/input/spelling.hpp>
#include <map>
#include <memory>

namespace impact {

namespace {

/// Names under which the peaks stand in the text; no column is called so.
std::string peak_name(std::size_t index) { return "peak_" + std::to_string(index) + "_"; }

/// One expression whose unknown names become variables.
struct Parsed {
  std::map<std::string, double> variables; // whose places stay where they are
  mu::Parser parser;

  static double* make(const char* name, void* self) { return &static_cast<Parsed*>(self)->variables[name]; }
};

} // namespace

Condition::Condition(std::string key, std::string text,
                     const std::vector<std::pair<std::string, double>>& parameters)
    : key_(std::move(key)), text_(std::move(text)) {
  refuse_assignment({key_, text_});
  whole_ = compile(take_peaks(), parameters);
  for (std::size_t i = 0; i < peaks_.size(); ++i) {
    std::erase(names_, peak_name(i));
    peaks_[i].argument = compile(peaks_[i].text, parameters);
  }
}

/// The text with each peak(argument) replaced by a name.
std::string Condition::take_peaks() {
  std::string rest = text_;
  for (std::size_t at = 0; (at = find_word(rest, "peak", at)) != std::string::npos;) {
    const std::size_t open = rest.find_first_not_of(" \t", at + 4);
    std::size_t end = open;
    for (int depth = 0; end < rest.size(); ++end) {
      depth += rest[end] == '(' ? 1 : rest[end] == ')' ? -1 : 0;
      if (depth == 0) break;
    }
    if (open == std::string::npos || rest[open] != '(' || end >= rest.size())
      refuse_option({key_, text_}, "peak takes an argument in brackets; allowed: peak(name)");
    const std::string argument = rest.substr(open + 1, end - open - 1);
    if (find_word(argument, "peak") != std::string::npos)
      refuse_option({key_, text_}, "a peak in a peak; allowed: peak(name)");
    const std::string name = peak_name(peaks_.size());
    peaks_.push_back({argument, std::nan(""), {}});
    rest.replace(at, end + 1 - at, name);
    at += name.size();
  }
  return rest;
}

std::function<double(const Condition::Value&)>
Condition::compile(const std::string& expression,
                   const std::vector<std::pair<std::string, double>>& parameters) {
  const auto parsed = std::make_shared<Parsed>();
  parsed->parser.SetVarFactory(Parsed::make, parsed.get());
  parse(parsed->parser, {key_, text_}, expression, parameters,
        "columns of the history, t, peak() and numbers in the units of the run (a -param_<id> takes units)");
  for (const auto& [name, place] : parsed->variables)
    if (std::ranges::find(names_, name) == names_.end()) names_.push_back(name);
  return [parsed](const Value& value) {
    for (auto& [name, place] : parsed->variables) place = value(name);
    return parsed->parser.Eval();
  };
}

void Condition::note(const Value& value) {
  for (Peak& peak : peaks_) peak.value = std::fmax(peak.value, peak.argument(value)); // not NaN
}

bool Condition::holds(const Value& value) const {
  const double result = whole_([&](const std::string& name) {
    for (std::size_t i = 0; i < peaks_.size(); ++i)
      if (name == peak_name(i)) return peaks_[i].value;
    return value(name);
  });
  return !std::isnan(result) && result != 0;
}

} // namespace impact

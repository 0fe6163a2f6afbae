#include "language.hpp"
#include <algorithm>
#include <cctype>
#include <cmath>
#include <impact/input/condition.hpp>
#include <map>

namespace impact {

namespace {

bool name_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Where `peak` stands as a name of its own in the text, from `from` on; npos where it does not.
std::size_t find_peak(const std::string& text, std::size_t from = 0) {
  const std::string word = "peak";
  for (std::size_t at = text.find(word, from); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !name_character(text[at - 1])) && (end == text.size() || !name_character(text[end])))
      return at;
  }
  return std::string::npos;
}

/// Names under which the peaks stand in the text; no column is called so.
std::string peak_name(std::size_t index) { return "peak_" + std::to_string(index) + "_"; }

} // namespace

struct Condition::Impl {
  /// One expression whose unknown names become variables.
  struct Part {
    std::map<std::string, std::unique_ptr<double>> variables;
    mu::Parser parser;

    static double* make(const char* name, void* part) {
      auto& value = static_cast<Part*>(part)->variables[name];
      if (!value) value = std::make_unique<double>(0);
      return value.get();
    }
    double operator()(const Value& value) {
      for (auto& [name, place] : variables) *place = value(name);
      return parser.Eval();
    }
  };

  std::string key, text;
  std::vector<std::string> peak_texts;
  std::vector<double> peaks;
  std::vector<std::unique_ptr<Part>> peaked;
  Part whole;

  Impl(std::string key_, std::string text_, const std::vector<std::pair<std::string, double>>& parameters)
      : key(std::move(key_)), text(std::move(text_)) {
    refuse_assignment(key, text);
    compile(whole, take_peaks(), parameters);
    for (const std::string& argument : peak_texts)
      compile(*peaked.emplace_back(std::make_unique<Part>()), argument, parameters);
    peaks.assign(peak_texts.size(), std::nan(""));
  }

  /// The text with each peak(argument) replaced by a name.
  std::string take_peaks() {
    std::string rest = text;
    for (std::size_t at = 0; (at = find_peak(rest, at)) != std::string::npos;) {
      const std::size_t open = rest.find_first_not_of(" \t", at + 4);
      std::size_t end = open;
      int depth = 0;
      for (; end < rest.size(); ++end) {
        depth += rest[end] == '(' ? 1 : rest[end] == ')' ? -1 : 0;
        if (depth == 0) break;
      }
      if (open == std::string::npos || rest[open] != '(' || end >= rest.size())
        refuse_expression(key, text, "peak takes an argument in brackets; allowed: peak(name)");
      const std::string argument = rest.substr(open + 1, end - open - 1);
      if (find_peak(argument) != std::string::npos)
        refuse_expression(key, text, "a peak in a peak; allowed: peak(name)");
      const std::string name = peak_name(peak_texts.size());
      peak_texts.push_back(argument);
      rest.replace(at, end + 1 - at, name);
      at += name.size();
    }
    return rest;
  }

  void compile(Part& part, const std::string& expression,
               const std::vector<std::pair<std::string, double>>& parameters) {
    try {
      define_language(part.parser);
      part.parser.SetVarFactory(Part::make, &part);
      for (const auto& [name, number] : parameters) part.parser.DefineConst(name, number);
      part.parser.SetExpr(expression);
      part.parser.Eval(); // muParser parses, and asks for its variables, at the first evaluation
      if (part.parser.GetNumResults() != 1) refuse_expression(key, text, "one value expected, not a list");
    } catch (const mu::Parser::exception_type& error) {
      refuse_expression(key, text, reason_of(error, "columns of the history, t and peak()"));
    }
  }
};

Condition::Condition(std::string key, std::string text,
                     const std::vector<std::pair<std::string, double>>& parameters)
    : impl_(std::make_unique<Impl>(std::move(key), std::move(text), parameters)) {}
Condition::Condition(Condition&&) noexcept = default;
Condition& Condition::operator=(Condition&&) noexcept = default;
Condition::~Condition() = default;

std::vector<std::string> Condition::names() const {
  std::vector<std::string> all;
  const auto add = [&](const Impl::Part& part) {
    for (const auto& [name, place] : part.variables) {
      const auto of_peak = [&, this] {
        for (std::size_t i = 0; i < impl_->peaks.size(); ++i)
          if (name == peak_name(i)) return true;
        return false;
      };
      if (!of_peak() && std::find(all.begin(), all.end(), name) == all.end()) all.push_back(name);
    }
  };
  add(impl_->whole);
  for (const auto& part : impl_->peaked) add(*part);
  return all;
}

const std::vector<std::string>& Condition::peak_texts() const { return impl_->peak_texts; }
std::vector<double>& Condition::peaks() { return impl_->peaks; }

void Condition::note(const Value& value) {
  for (std::size_t i = 0; i < impl_->peaks.size(); ++i)
    impl_->peaks[i] =
        std::fmax(impl_->peaks[i], (*impl_->peaked[i])(value)); // fmax: the one that is a number
}

bool Condition::holds(const Value& value) const {
  const double result = impl_->whole([&](const std::string& name) {
    for (std::size_t i = 0; i < impl_->peaks.size(); ++i)
      if (name == peak_name(i)) return impl_->peaks[i];
    return value(name);
  });
  return !std::isnan(result) && result != 0;
}

const std::string& Condition::key() const { return impl_->key; }
const std::string& Condition::text() const { return impl_->text; }

} // namespace impact

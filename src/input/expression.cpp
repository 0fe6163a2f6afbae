#include "language.hpp"
#include <algorithm>
#include <cmath>
#include <impact/input/expression.hpp>
#include <impact/input/units.hpp>
#include <impact/petsc/error.hpp>
#include <sstream>

namespace impact {

namespace {

double ramp(double t, double t0, double t1) {
  if (t1 <= t0) return t < t0 ? 0. : 1.;
  return std::clamp((t - t0) / (t1 - t0), 0., 1.);
}
double step(double t, double t0) { return t < t0 ? 0. : 1.; }
double pulse(double t, double t0, double t1) { return t >= t0 && t < t1 ? 1. : 0.; }
/// 0 at the start, 1 in the middle and 0 at the end of each period, linear in between.
double cycle(double t, double period) {
  const double turns = t / period, part = turns - std::floor(turns);
  return 1 - std::abs(2 * part - 1);
}
double look_up(void* table, double t) { return (*static_cast<const LinearTable*>(table))(t); }

std::string known_names(const ExpressionContext& context) {
  std::string names = "x y z t pi e";
  for (const auto& [name, value] : context.parameters) names += " " + name;
  for (const auto& [name, table] : context.tables) names += " " + name + "()";
  return names;
}

} // namespace

void define_language(mu::Parser& parser) {
  parser.ClearConst();
  parser.DefineConst("pi", 3.14159265358979323846);
  parser.DefineConst("e", 2.71828182845904523536);
  parser.DefineFun("ramp", ramp);
  parser.DefineFun("step", step);
  parser.DefineFun("pulse", pulse);
  parser.DefineFun("cycle", cycle);
}

std::string function_names() {
  mu::Parser parser;
  define_language(parser);
  std::string names;
  for (const auto& [name, function] : parser.GetFunDef()) names += " " + name;
  return names;
}

void refuse_assignment(const GivenOption& option) {
  for (std::size_t at = 0; (at = option.text.find('=', at)) != std::string::npos; ++at)
    if (option.text.substr(at).starts_with("=="))
      ++at;
    else if (at == 0 || std::string("<>!").find(option.text[at - 1]) == std::string::npos)
      refuse_option(option, "'=' at character " + std::to_string(at) +
                                " assigns; allowed: an expression, compare with ==");
}

void parse(mu::Parser& parser, const GivenOption& option, const std::string& part,
           const std::vector<std::pair<std::string, double>>& parameters, const std::string& known) {
  try {
    define_language(parser);
    for (const auto& [name, value] : parameters) parser.DefineConst(name, value);
    parser.SetExpr(part);
    parser.Eval(); // muParser parses, and asks for its variables, at the first evaluation
    if (parser.GetNumResults() != 1) refuse_option(option, "one value expected, not a list");
  } catch (const mu::Parser::exception_type& error) {
    const std::string place = " at character " + std::to_string(error.GetPos());
    if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN)
      refuse_option(option, "unknown name '" + error.GetToken() + "'" + place + "; known: " + known +
                                "; functions:" + function_names());
    std::string message = error.GetMsg();
    while (!message.empty() && (message.back() == '.' || message.back() == '\n')) message.pop_back();
    if (message.find("position") == std::string::npos && error.GetPos() >= 0) message += place;
    refuse_option(option, message + "; allowed: an expression of " + known);
  }
}

double LinearTable::operator()(double at) const {
  const auto above = std::ranges::upper_bound(t, at);
  if (above == t.begin()) return value.front();
  if (above == t.end()) return value.back();
  const auto i = static_cast<std::size_t>(above - t.begin());
  return value[i - 1] + (value[i] - value[i - 1]) * ((at - t[i - 1]) / (t[i] - t[i - 1]));
}

LinearTable parse_table(const std::string& csv) {
  LinearTable table;
  std::istringstream lines(csv);
  std::string line;
  bool header_seen = false;
  for (int number = 1; std::getline(lines, line); ++number) {
    const auto fail = [number](const char* reason) {
      throw std::invalid_argument("line " + std::to_string(number) + ": " + reason);
    };
    line.erase(std::ranges::find(line, '#'), line.end());
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == ',' || c == ';' || c == '\r'; }, ' ');
    std::istringstream words(line);
    std::vector<std::string> word;
    for (std::string next; words >> next;) word.push_back(next);
    if (word.empty()) continue;
    const auto t = parse_number(word[0]);
    if (!t && table.t.empty() && !std::exchange(header_seen, true)) continue;
    const auto value = word.size() == 2 ? parse_number(word[1]) : std::nullopt;
    if (!t || !value) fail("two numbers expected");
    if (!table.t.empty() && *t <= table.t.back()) fail("the first column must increase");
    table.t.push_back(*t);
    table.value.push_back(*value);
  }
  if (table.t.empty()) throw std::invalid_argument("no rows");
  return table;
}

bool reserved_in_expressions(const std::string& name) {
  for (const char* variable : {"x", "y", "z", "t", "and", "or", "not"})
    if (name == variable) return true;
  mu::Parser parser;
  define_language(parser);
  return parser.GetConst().count(name) != 0 || parser.GetFunDef().count(name) != 0;
}

struct Expression::Impl {
  GivenOption said;
  std::string allowed = "finite values everywhere and always";
  Interval range = {};
  std::vector<std::pair<std::string, LinearTable>> tables = {};
  std::function<double(const double*, int, double)> function = {}; // in place of the parsed text
  double variable[4] = {0, 0, 0, 0};
  mu::Parser parser = {};
};

Expression::Expression(std::string key, std::string text, const ExpressionContext* context)
    : impl_(std::make_shared<Impl>()) {
  const ExpressionContext names = context != nullptr ? *context : ExpressionContext{};
  impl_->said = {std::move(key), std::move(text)};
  impl_->tables = names.tables;
  refuse_assignment(impl_->said);
  for (int i = 0; i < 4; ++i) impl_->parser.DefineVar(std::string(1, "xyzt"[i]), &impl_->variable[i]);
  for (auto& [name, table] : impl_->tables) impl_->parser.DefineFunUserData(name, look_up, &table, false);
  parse(impl_->parser, impl_->said, impl_->said.text, names.parameters, known_names(names));
}

Expression::Expression(std::string key, std::function<double(const double*, int, double)> function)
    : impl_(std::make_shared<Impl>()) {
  impl_->said = {std::move(key), "function"};
  impl_->function = std::move(function);
}

void Expression::restrict_to(const Interval& range, const std::string& allowed) {
  impl_->range = range;
  impl_->allowed = allowed;
}

double Expression::operator()(const double* x, int dim, double t) const {
  Impl& impl = *impl_;
  for (int i = 0; i < 3; ++i) impl.variable[i] = i < dim ? x[i] : 0.;
  impl.variable[3] = t;
  const double value = impl.function ? impl.function(x, dim, t) : impl.parser.Eval();
  constexpr double rounding = 1e-12;
  const double near = std::clamp(value, impl.range.low, impl.range.high);
  if (std::isfinite(value) && impl.range.contains(near) && std::abs(value - near) <= rounding) [[likely]]
    return near;
  std::string point;
  for (int i = 0; i < dim; ++i) point += (i ? "," : "") + number_text(x[i]);
  throw UserError(ExitCode::data, impl.said.key + " \"" + impl.said.text + "\": " + number_text(value) +
                                      " at x=(" + point + "), t=" + number_text(t) +
                                      "; allowed: " + impl.allowed);
}

bool Expression::asks_for_time() const {
  return !impl_->function && impl_->parser.GetUsedVar().contains("t");
}

const std::string& Expression::key() const { return impl_->said.key; }
const std::string& Expression::text() const { return impl_->said.text; }

} // namespace impact

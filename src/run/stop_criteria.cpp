#include <charconv>
#include <cmath>
#include <impact/input/spelling.hpp>
#include <impact/run/stop_criteria.hpp>
#include <sstream>

namespace impact {

namespace {

/// The number of a column; `t` is the column `time`, unless there is one called so.
const double* find_column(const HistoryFile::Row& row, const std::string& name) {
  for (const auto& [column, value] : row)
    if (column == name) return &value;
  return name == "t" ? find_column(row, "time") : nullptr;
}

Condition::Value columns_of(const HistoryFile::Row& row) {
  return [&row](const std::string& name) {
    const double* const value = find_column(row, name);
    if (value == nullptr) throw std::logic_error("stop: column " + name + " has gone");
    return *value;
  };
}

constexpr const char* stored_name = "peaks"; // lines of a number and the text of what it is the peak of

} // namespace

StopCriteria::StopCriteria(MPI_Comm comm, const Scenario& scenario) : comm_(comm) {
  std::vector<std::pair<std::string, double>> parameters;
  for (const auto& parameter : scenario.params) parameters.emplace_back(parameter.id, parameter.value);
  for (const auto& stop : scenario.stops)
    criteria_.emplace_back("-stop_" + stop.id + "_when", stop.when, parameters);
}

void StopCriteria::check_names(const HistoryFile::Row& row) const {
  std::vector<std::string> columns;
  for (const auto& [column, value] : row) columns.push_back(column);
  for (const Condition& criterion : criteria_)
    for (const std::string& name : criterion.names()) {
      if (find_column(row, name) != nullptr) continue;
      const std::string near = nearest_name(name, columns, 3);
      throw UserError(ExitCode::usage, criterion.key() + " \"" + criterion.text() +
                                           "\": the history has no column '" + name + "'" +
                                           (near.empty() ? "" : "; did you mean " + near + "?") +
                                           "; it has: " + join(columns, " "));
    }
}

std::string StopCriteria::ask(const HistoryFile::Row& row) {
  int held = static_cast<int>(criteria_.size());
  for (std::size_t i = criteria_.size(); i-- > 0;) {
    criteria_[i].note(columns_of(row));
    if (criteria_[i].holds(columns_of(row))) held = static_cast<int>(i);
  }
  MPI_Bcast(&held, 1, MPI_INT, 0, comm_);
  if (held == static_cast<int>(criteria_.size())) return "";
  const Condition& criterion = criteria_[static_cast<std::size_t>(held)];
  return criterion.key() + " \"" + criterion.text() + "\"";
}

void StopCriteria::store(CheckpointValues& values) const {
  std::string lines;
  for (Condition& criterion : criteria_)
    for (const Condition::Peak& peak : criterion.peaks())
      if (!std::isnan(peak.value)) lines += number_text(peak.value) + " " + peak.text + "\n";
  if (!lines.empty()) values.texts[stored_name] = lines;
}

std::vector<std::string> StopCriteria::restore(const CheckpointValues& values) {
  const auto stored = values.texts.find(stored_name);
  std::istringstream in(stored == values.texts.end() ? "" : stored->second);
  std::map<std::string, double> peaks;
  for (std::string number, text; in >> number && in.get() && std::getline(in, text);)
    std::from_chars(number.data(), number.data() + number.size(), peaks[text]);
  std::vector<std::string> missing;
  for (Condition& criterion : criteria_)
    for (Condition::Peak& peak : criterion.peaks())
      if (const auto found = peaks.find(peak.text); found != peaks.end())
        peak.value = found->second;
      else
        missing.push_back(peak.text);
  return missing;
}

} // namespace impact

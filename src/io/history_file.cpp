#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <impact/input/spelling.hpp>
#include <impact/io/history_file.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

namespace {

// to_chars, because printf follows the locale's decimal comma.
std::string digits17(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value < 0 ? "-inf" : "inf";
  std::array<char, 40> text;
  return {text.data(),
          std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 17).ptr};
}

} // namespace

HistoryFile::HistoryFile(MPI_Comm comm, std::string file, std::optional<long> resume_after,
                         std::function<std::string(const std::string&)> unit, const Row& expected)
    : comm_(comm), file_(std::move(file)), unit_(std::move(unit)) {
  on_rank_zero(comm_, [&] {
    make_directories(std::filesystem::path(file_).parent_path().string());
    const bool keep = resume_after && std::filesystem::exists(file_);
    out_.emplace(file_, keep ? DurableFile::Mode::update : DurableFile::Mode::create);
    if (keep) resume(*resume_after, expected);
  });
  MPI_Bcast(&last_step_, 1, MPI_LONG, 0, comm_);
}

// Keeps what comes before the first row of a later step. A row that is not whole ends the file there too: it
// is what a kill left of a write.
void HistoryFile::resume(long last_step, const Row& expected) {
  const std::string text = read_file(file_);
  std::size_t keep = 0;
  for (std::size_t at = 0, end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    const std::string line = text.substr(at, end - at);
    if (line.empty() || line[0] != '#') {
      const std::vector<std::string> cells = split_list(line);
      if (columns_.empty()) {
        if (cells.empty() || cells[0] != "step")
          throw UserError(ExitCode::io, "cannot continue " + file_ +
                                            ": its first line has no column `step`, so it is no "
                                            "history of this program; move it away or name another file");
        for (const std::string& cell : cells) columns_.push_back(cell.substr(0, cell.find(" [")));
      } else {
        double step = 0;
        const bool whole =
            cells.size() == columns_.size() &&
            std::from_chars(cells[0].data(), cells[0].data() + cells[0].size(), step).ec == std::errc();
        if (!whole || step > static_cast<double>(last_step)) break;
        last_step_ = static_cast<long>(step);
      }
    }
    keep = end + 1;
  }
  length_ = columns_.empty() ? 0 : keep;
  resumed_ = !columns_.empty();
  if (resumed_) line(expected);
  out_->resize(length_);
}

// The part of a refused row that was written is cut off again.
void HistoryFile::append(const std::string& text) {
  try {
    out_->write(length_, text.data(), text.size());
  } catch (const UserError& error) {
    try {
      out_->resize(length_);
    } catch (const UserError&) {
      throw UserError(ExitCode::io, std::string(error.what()) + " (its last row is not whole)");
    }
    throw;
  }
  length_ += text.size();
}

std::string HistoryFile::header(const Row& row) const {
  std::string text;
  for (const auto& [name, value] : row) text += (text.empty() ? "" : ",") + name + (unit_ ? unit_(name) : "");
  return text + "\n";
}

std::string HistoryFile::line(const Row& row) const {
  std::vector<double> values(columns_.size(), std::nan(""));
  for (const auto& [name, value] : row) {
    const auto found = std::ranges::find(columns_, name);
    if (found == columns_.end() && resumed_)
      throw UserError(ExitCode::io,
                      "cannot continue " + file_ + ": it has no column " + name +
                          ": a probe, measure, condition, contact or -ts_type that the run did not have "
                          "before; leave it out, or begin another file with -output_<id>_type csv, "
                          "-output_<id>_file");
    if (found == columns_.end())
      throw std::logic_error("history: column " + name + " was not in the first row");
    values[static_cast<std::size_t>(found - columns_.begin())] = value;
  }
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ",") + digits17(value);
  return text + "\n";
}

void HistoryFile::write(const Row& row) {
  on_rank_zero(comm_, [&] {
    if (columns_.empty()) {
      if (row.empty() || row[0].first != "step")
        throw std::logic_error("history: the first column must be `step`");
      const std::string names = header(row);
      for (const auto& [name, value] : row) columns_.push_back(name);
      try {
        append(names);
      } catch (...) {
        columns_.clear();
        throw;
      }
    }
    append(line(row));
  });
}

} // namespace impact

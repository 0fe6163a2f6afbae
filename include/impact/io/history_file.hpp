#pragma once
#include <functional>
#include <impact/io/durable_file.hpp>
#include <optional>
#include <petscsys.h>
#include <utility>

/// The history of a run as comma-separated text: one line of column names and units (`time [s]`), then one
/// row per accepted step, the first column `step`. 17 significant digits (every double reads back exactly),
/// `nan` for what is missing, never an empty cell. Each row is handed to the system at once.
namespace impact {

class HistoryFile {
public:
  using Row = std::vector<std::pair<std::string, double>>; ///< column names and values

  /// Starts the file, or with `resume_after` continues it: rows of later steps and a half-written last one
  /// are dropped, units in its first line are passed over. `unit` gives what stands behind a name, " [s]" or
  /// "". `expected`: columns that a file to be continued must have; without one of them it stays as it is.
  /// Missing directories are made. Collective. Throws UserError(io) on all ranks.
  HistoryFile(MPI_Comm comm, std::string file, std::optional<long> resume_after = std::nullopt,
              std::function<std::string(const std::string&)> unit = {}, const Row& expected = {});

  /// Appends one row; rank 0's values are written. The first row of a file fixes the columns and must begin
  /// with `step`; later rows may come in any order and leave columns out (`nan`), a new column is a
  /// std::logic_error, or UserError(io) when a resumed file has other columns. Collective. Throws
  /// UserError(io) on all ranks when the disk refuses; the file then ends with the last whole row.
  void write(const Row& row);

  /// Column names in the file's order; empty before the first row. On rank 0.
  const std::vector<std::string>& columns() const { return columns_; }

  /// Step of the last row that was kept from before, -1 when there is none.
  long last_step() const { return last_step_; }

private:
  void resume(long last_step, const Row& expected);
  void append(const std::string& text);
  std::string header(const Row& row) const;
  std::string line(const Row& row) const;

  MPI_Comm comm_;
  std::string file_;
  std::function<std::string(const std::string&)> unit_;
  std::optional<DurableFile> out_; // on rank 0
  std::uint64_t length_ = 0;       // bytes up to the end of the last whole row
  bool resumed_ = false;
  long last_step_ = -1;
  std::vector<std::string> columns_;
};

} // namespace impact

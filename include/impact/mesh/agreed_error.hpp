#pragma once
#include <impact/petsc/error.hpp>
#include <string>

namespace impact {

/// Ends a check that each rank made on its own part: when some rank gives a message, the lowest such rank's
/// message is thrown as UserError on all ranks; when all are empty, returns. Collective.
inline void throw_first(MPI_Comm comm, ExitCode code, const std::string& message) {
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const int mine = message.empty() ? size : rank;
  int first = size;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first == size) return;
  int length = static_cast<int>(message.size());
  MPI_Bcast(&length, 1, MPI_INT, first, comm);
  std::string text = message;
  text.resize(static_cast<std::size_t>(length));
  MPI_Bcast(text.data(), length, MPI_CHAR, first, comm);
  throw UserError(code, text);
}

/// Runs `body`, which may throw UserError on some ranks only (a user's expression at a rank's own points),
/// and throws the message of the lowest such rank on all of them. Collective; `body` itself must not
/// communicate.
template <class Body> void agree_on_errors(MPI_Comm comm, Body&& body) {
  std::string message;
  ExitCode code = ExitCode::data;
  try {
    body();
  } catch (const UserError& error) {
    message = error.what();
    code = error.code();
  }
  int worst = message.empty() ? 0 : static_cast<int>(code);
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_INT, MPI_MAX, comm);
  if (worst != 0) throw_first(comm, static_cast<ExitCode>(worst), message);
}

} // namespace impact

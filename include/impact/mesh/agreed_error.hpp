#pragma once
#include <impact/petsc/error.hpp>
#include <string>
#include <utility>

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

/// What bodies could not do on some ranks only (a user's expression at a rank's own points).
class RankErrors {
public:
  /// Runs `body`, which must not communicate, and keeps the message of the first UserError that it throws.
  template <class Body> void note(Body&& body) {
    try {
      body();
    } catch (const UserError& error) {
      if (!message_.empty()) return;
      message_ = error.what();
      code_ = error.code();
    }
  }
  /// What `agree` wants the largest of over the ranks.
  double worst() const { return message_.empty() ? 0 : static_cast<double>(code_); }
  /// Throws the message of the lowest rank that has one on all of them. Collective.
  void agree(MPI_Comm comm, double worst) {
    if (worst > 0) throw_first(comm, static_cast<ExitCode>(worst), std::exchange(message_, {}));
  }

private:
  std::string message_;
  ExitCode code_ = ExitCode::data;
};

/// Runs `body` likewise; the ranks agree at once. Collective.
template <class Body> void agree_on_errors(MPI_Comm comm, Body&& body) {
  RankErrors errors;
  errors.note(body);
  double worst = errors.worst();
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE, MPI_MAX, comm);
  errors.agree(comm, worst);
}

} // namespace impact

#include <impact/petsc/error.hpp>
#include <utility>

namespace impact {

namespace {

// PETSc's error handler is a process-wide hook, so its record has to be process-wide too.
struct Record {
  std::string said, place;
};
Record& record() {
  static Record message;
  return message;
}

PetscErrorCode quiet_handler(MPI_Comm, int line, const char* function, const char* file, PetscErrorCode code,
                             PetscErrorType type, const char* message, void*) {
  if (type == PETSC_ERROR_INITIAL || record().said.empty())
    record() = {message ? message : "", std::string(function ? function : "") + ", " + (file ? file : "") +
                                            ":" + std::to_string(line)};
  return code;
}

std::string describe(PetscErrorCode code, const std::source_location& where) {
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  std::string message = text ? text : "PETSc error " + std::to_string(code);
  if (!record().said.empty()) message += "; " + record().said + " (" + record().place + ")";
  return message + " [" + where.file_name() + ":" + std::to_string(where.line()) + "]";
}

} // namespace

PetscError::PetscError(PetscErrorCode code, const std::source_location& where)
    : std::runtime_error(describe(code, where)), code_(code), said_(last_petsc_message()) {}

void Mailbox::deliver(PetscErrorCode code, const std::source_location& where) {
  if (first_) {
    last_petsc_message();
    std::rethrow_exception(std::exchange(first_, nullptr));
  }
  check(code, where);
}

bool all_ranks_agree(MPI_Comm comm, bool mine) {
  int local = mine ? 1 : 0, global = 0;
  MPI_Allreduce(&local, &global, 1, MPI_INT, MPI_MIN, comm);
  return global == 1;
}

void install_quiet_error_handler() { PetscPushErrorHandler(quiet_handler, nullptr); }

std::string last_petsc_message() { return std::exchange(record(), Record()).said; }

std::string broadcast(MPI_Comm comm, std::string text) {
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, comm);
  text.resize(static_cast<std::size_t>(length));
  MPI_Bcast(text.data(), length, MPI_CHAR, 0, comm);
  return text;
}

} // namespace impact

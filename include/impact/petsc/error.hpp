#pragma once
#include <exception>
#include <petscsys.h>
#include <source_location>
#include <stdexcept>
#include <string>

/// Three kinds of trouble: a user's error (UserError, thrown alike on all ranks before a collective call),
/// loss of physical meaning (never an exception: a collective domain error, see all_ranks_agree), a failure
/// of PETSc or a bug (PetscError, carried across PETSc's C callbacks by `guarded`).
namespace impact {

enum class ExitCode { ok = 0, usage = 2, data = 3, io = 4, solver = 5, internal = 6 };

/// What the user can mend: one line saying what, where, what is allowed and the remedy. Thrown on all ranks.
class UserError : public std::runtime_error {
public:
  UserError(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

private:
  ExitCode code_;
};

/// A PETSc call returned an error code.
class PetscError : public std::runtime_error {
public:
  PetscError(PetscErrorCode code, const std::source_location& where);
  PetscErrorCode code() const { return code_; }
  /// PETSc's innermost message without the place in its source.
  const std::string& said() const { return said_; }

private:
  PetscErrorCode code_;
  std::string said_;
};

/// Throws PetscError when `code` is not zero.
inline void check(PetscErrorCode code, const std::source_location& where = std::source_location::current()) {
  if (code != 0) [[unlikely]]
    throw PetscError(code, where);
}

/// Of the body of a type that PETSc calls, whose functions may not be left by an exception: its error code.
template <class Body> PetscErrorCode guarded(Body&& body) {
  try {
    body();
    return 0;
  } catch (const PetscError& error) {
    return error.code();
  }
}

/// Holds the first exception thrown inside a PETSc callback until the solve has returned.
class Mailbox {
public:
  /// Runs `body`; an exception is stored and turned into an error code for PETSc.
  template <class Body> PetscErrorCode guarded(Body&& body) noexcept {
    try {
      body();
      return 0;
    } catch (...) {
      if (!first_) first_ = std::current_exception();
      return PETSC_ERR_USER;
    }
  }
  /// After a PETSc solve that returned `code`: rethrows what a callback stored, else throws for a nonzero
  /// code.
  void deliver(PetscErrorCode code, const std::source_location& where = std::source_location::current());

private:
  std::exception_ptr first_;
};

/// True on all ranks when `mine` is true on all of them. Collective.
bool all_ranks_agree(MPI_Comm comm, bool mine);

/// Rank 0 evaluates `body`; what it throws as UserError is thrown on all ranks. Collective.
template <class Body> void on_rank_zero(MPI_Comm comm, Body&& body);

/// PETSc error handler of the program: records the innermost message, prints nothing, so that one clear line
/// is printed by main instead of a traceback on each rank. Installed once, after PetscInitialize.
void install_quiet_error_handler();
/// The innermost PETSc message recorded since the last call, without the place in its source.
std::string last_petsc_message();

/// Rank 0's text on all ranks. Collective.
std::string broadcast(MPI_Comm comm, std::string text);

template <class Body> void on_rank_zero(MPI_Comm comm, Body&& body) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::string message;
  int code = 0;
  if (rank == 0) {
    try {
      body();
    } catch (const UserError& error) {
      code = static_cast<int>(error.code());
      message = error.what();
    } catch (const std::exception& error) {
      code = static_cast<int>(ExitCode::internal);
      message = error.what();
    }
  }
  MPI_Bcast(&code, 1, MPI_INT, 0, comm);
  if (code != 0) throw UserError(static_cast<ExitCode>(code), broadcast(comm, message));
}

} // namespace impact

#pragma once
#include <functional>
#include <impact/petsc/handle.hpp>
#include <map>
#include <string>
#include <vector>

/// What PETSc's own options are called and what they take, asked of PETSc: each kind of solver is made once
/// for two unknowns and told to print its `-help`, which is read. So a misspelt name is known before a run
/// starts, and a value that PETSc refuses is answered with what is allowed, whatever its version.
namespace impact {

class KnownOptions {
public:
  /// Names in lower case, and what `-help` says behind each.
  using Table = std::map<std::string, std::string>;

  /// Each rank asks by itself, at the first call: about 50 ms.
  static const KnownOptions& get();

  /// Options behind the prefix of a solver or an integrator: `snes_`, `ksp_`, `pc_`, `ts_`, ...
  const Table& solver() const { return solver_; }
  /// Options without one, of matrices, vectors and partitioners, and those of integrators.
  const Table& global() const { return global_; }
  /// What `-help` says of an option of a solver or of one inside it (`mg_levels_2_ksp_type`); null: no such
  /// option. The prefixes in between are not looked at, for only a solve can tell them.
  const std::string* of_solver(const std::string& name) const;
  /// none, jacobi, ... for an option with or without prefixes; empty when PETSc does not list it.
  std::vector<std::string> allowed(const std::string& name) const;

private:
  KnownOptions();
  Table solver_, global_;
};

/// The identity, two rows on each rank: what solvers are tried on. Collective.
Handle<Mat> small_matrix(MPI_Comm comm);

/// Runs `set_up`, which makes objects from their options, in a copy of the unread options that begin with
/// `prefix`: none of them counts as used by it. Collective. Throws UserError(usage) for a value that PETSc
/// refuses.
void try_options(const std::string& prefix, const std::function<void()>& set_up);

/// The option that a message of PETSc speaks of, found by its value, as a message to the user; without such
/// a one the types of solvers that were chosen; "" when there are none.
std::string refused_option(const std::string& petsc_message);

} // namespace impact

#pragma once
#include <impact/petsc/handle.hpp>
#include <vector>

/// Values of chosen nodes, wherever they live, on this rank and back: one message per partner each way.
namespace impact {

class NodeExchange {
public:
  NodeExchange() = default;
  /// `nodes`: global nodes wanted here, each once; `owned`: nodes owned by this rank; node-blocked global
  /// vectors of `components` per node. Collective.
  NodeExchange(MPI_Comm comm, PetscInt owned, int components, const std::vector<PetscInt>& nodes);

  /// [node][component] of the wanted nodes, current values of `global`. Collective.
  std::vector<double> gather(Vec global) const;
  /// Adds [node][component] into the owners' entries of `global`. Collective.
  void add(const std::vector<double>& values, Vec global) const;

private:
  Handle<PetscSF> sf_;
  std::size_t size_ = 0;
};

} // namespace impact

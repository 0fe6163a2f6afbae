#include <impact/contact/node_exchange.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

NodeExchange::NodeExchange(MPI_Comm comm, PetscInt owned, int components, const std::vector<PetscInt>& nodes)
    : size_(nodes.size() * static_cast<std::size_t>(components)) {
  std::vector<PetscInt> dofs;
  dofs.reserve(size_);
  for (PetscInt node : nodes)
    for (PetscInt k = 0; k < components; ++k) dofs.push_back(node * components + k);
  PetscLayout layout = nullptr;
  check(PetscLayoutCreate(comm, &layout));
  check(PetscLayoutSetLocalSize(layout, owned * components));
  check(PetscLayoutSetUp(layout));
  check(PetscSFCreate(comm, sf_.out()));
  check(PetscSFSetGraphLayout(sf_, layout, static_cast<PetscInt>(size_), nullptr, PETSC_OWN_POINTER,
                              dofs.data()));
  check(PetscLayoutDestroy(&layout));
  check(PetscSFSetUp(sf_));
}

std::vector<double> NodeExchange::gather(Vec global) const {
  std::vector<double> values(size_);
  const PetscScalar* owned = nullptr;
  check(VecGetArrayRead(global, &owned));
  check(PetscSFBcastBegin(sf_, MPIU_SCALAR, owned, values.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf_, MPIU_SCALAR, owned, values.data(), MPI_REPLACE));
  check(VecRestoreArrayRead(global, &owned));
  return values;
}

void NodeExchange::add(const std::vector<double>& values, Vec global) const {
  PetscScalar* owned = nullptr;
  check(VecGetArray(global, &owned));
  check(PetscSFReduceBegin(sf_, MPIU_SCALAR, values.data(), owned, MPIU_SUM));
  check(PetscSFReduceEnd(sf_, MPIU_SCALAR, values.data(), owned, MPIU_SUM));
  check(VecRestoreArray(global, &owned));
}

} // namespace impact

#include <impact/mesh/shifted_mesh.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

Mesh shifted_mesh(const Mesh& mesh, const std::vector<double>& shift) {
  check(PetscObjectReference(reinterpret_cast<PetscObject>(mesh.dm())));
  Handle<DM> dm(mesh.dm());
  Vec before = nullptr;
  PetscSection section = nullptr;
  check(DMGetCoordinatesLocal(dm, &before));
  check(DMGetCoordinateSection(dm, &section));
  Handle<Vec> after;
  check(VecDuplicate(before, after.out()));
  check(VecCopy(before, after));
  PetscScalar* x = nullptr;
  check(VecGetArray(after, &x));
  for (int node = 0; node < mesh.node_count(); ++node) {
    PetscInt offset = 0;
    check(PetscSectionGetOffset(section, mesh.vertex_point(node), &offset));
    for (int k = 0; k < mesh.dim(); ++k)
      x[offset + k] += shift[static_cast<std::size_t>(node * mesh.dim() + k)];
  }
  check(VecRestoreArray(after, &x));
  check(DMSetCoordinatesLocal(dm, after)); // the global ones are made afresh from these
  return Mesh(std::move(dm), mesh.groups());
}

} // namespace impact

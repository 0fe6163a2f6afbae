#include <algorithm>
#include <impact/mesh/field_layout.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

FieldLayout::FieldLayout(const Mesh& mesh, std::string name, int components)
    : name_(std::move(name)), components_(components), node_count_(mesh.node_count()) {
  check(DMClone(mesh.dm(), dm_.out()));
  check(DMSetNumFields(dm_, 1));
  const Handle<PetscSection> section = node_section(dm_, node_map(mesh.dm()), components_);
  check(PetscSectionSetFieldName(section, 0, name_.c_str()));
  check(DMSetLocalSection(dm_, section));
  // The local vector borrows the caller's arrays; it needs none of its own.
  check(VecCreateSeqWithArray(PETSC_COMM_SELF, components_, static_cast<PetscInt>(node_count_) * components_,
                              nullptr, work_.out()));
  PetscInt first = PETSC_MAX_INT;
  for (int node = 0; node < node_count_; ++node) {
    if (!mesh.owned(node)) continue;
    const PetscInt place = mesh.global_node()[static_cast<std::size_t>(node)];
    first = std::min(first, place);
    if (!owned_.empty() && owned_.back().node + owned_.back().count == node &&
        owned_.back().place + owned_.back().count == place)
      ++owned_.back().count;
    else
      owned_.push_back({node, place, 1});
  }
  for (Row& row : owned_) row.place -= first;
}

// A copy of one that the DM keeps: it walks all points of the mesh to make another.
Handle<Vec> FieldLayout::make_global() const {
  constexpr const char* pattern = "pattern";
  Handle<Vec> x;
  Vec kept = nullptr;
  check(DMGetNamedGlobalVector(dm_, pattern, &kept));
  check(VecSetBlockSize(kept, components_));
  check(VecDuplicate(kept, x.out()));
  check(DMRestoreNamedGlobalVector(dm_, pattern, &kept));
  check(VecZeroEntries(x));
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(x.get()), name_.c_str()));
  return x;
}

std::vector<double> FieldLayout::make_local() const {
  return std::vector<double>(static_cast<std::size_t>(node_count_) * static_cast<std::size_t>(components_));
}

void FieldLayout::to_local(Vec global, std::vector<double>& local) const {
  check(VecPlaceArray(work_, local.data()));
  check(DMGlobalToLocal(dm_, global, INSERT_VALUES, work_));
  check(VecResetArray(work_));
}

void FieldLayout::owned_to_local(Vec global, std::vector<double>& local) const {
  const double* values = nullptr;
  check(VecGetArrayRead(global, &values));
  for (const Row& row : owned_)
    std::copy_n(values + row.place * components_, row.count * components_,
                &local[static_cast<std::size_t>(row.node * components_)]);
  check(VecRestoreArrayRead(global, &values));
}

void FieldLayout::add_to_global(const std::vector<double>& local, Vec global) const {
  check(VecPlaceArray(work_, local.data()));
  check(DMLocalToGlobal(dm_, work_, ADD_VALUES, global));
  check(VecResetArray(work_));
}

// DMLocalToGlobal with INSERT_VALUES walks all points of the mesh.
void FieldLayout::to_global(const std::vector<double>& local, Vec global) const {
  double* values = nullptr;
  check(VecGetArray(global, &values));
  for (const Row& row : owned_)
    std::copy_n(&local[static_cast<std::size_t>(row.node * components_)], row.count * components_,
                values + row.place * components_);
  check(VecRestoreArray(global, &values));
}

Handle<MatNullSpace> near_null_space(const FieldLayout& layout, const Mesh& mesh) {
  Handle<Vec> coordinates = layout.make_global();
  const std::vector<double> x(mesh.coordinates().begin(), mesh.coordinates().end());
  layout.to_global(x, coordinates);
  Handle<MatNullSpace> modes;
  check(MatNullSpaceCreateRigidBody(coordinates, modes.out()));
  return modes;
}

} // namespace impact

#include <impact/mesh/field_layout.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

FieldLayout::FieldLayout(const Mesh& mesh, std::string name, int components)
    : name_(std::move(name)), components_(components), node_count_(mesh.node_count()) {
  check(DMClone(mesh.dm(), dm_.out()));
  PetscInt chart_start = 0, chart_end = 0;
  check(DMPlexGetChart(dm_, &chart_start, &chart_end));
  Handle<PetscSection> section;
  check(PetscSectionCreate(mesh.comm(), section.out()));
  check(PetscSectionSetNumFields(section, 1)); // before the chart, else PETSc 3.18 crashes
  check(PetscSectionSetFieldName(section, 0, name_.c_str()));
  check(PetscSectionSetFieldComponents(section, 0, components_));
  check(PetscSectionSetChart(section, chart_start, chart_end));
  for (int n = 0; n < node_count_; ++n) {
    check(PetscSectionSetDof(section, mesh.vertex_point(n), components_));
    check(PetscSectionSetFieldDof(section, mesh.vertex_point(n), 0, components_));
  }
  check(PetscSectionSetUp(section));
  check(DMSetLocalSection(dm_, section));
  // The local vector borrows the caller's arrays; it needs none of its own.
  check(VecCreateSeqWithArray(PETSC_COMM_SELF, components_, static_cast<PetscInt>(node_count_) * components_,
                              nullptr, work_.out()));
}

Handle<Vec> FieldLayout::make_global() const {
  Handle<Vec> x;
  check(DMCreateGlobalVector(dm_, x.out()));
  check(VecSetBlockSize(x, components_));
  check(VecZeroEntries(x));
  check(PetscObjectSetName(reinterpret_cast<PetscObject>(x.get()), name_.c_str()));
  return x;
}

std::vector<double> FieldLayout::make_local() const {
  return std::vector<double>(static_cast<std::size_t>(node_count_) * static_cast<std::size_t>(components_));
}

void FieldLayout::to_local(Vec global, std::vector<double>& local) const {
  check(VecPlaceArray(work_, local.data()));
  check(DMGlobalToLocalBegin(dm_, global, INSERT_VALUES, work_));
  check(DMGlobalToLocalEnd(dm_, global, INSERT_VALUES, work_));
  check(VecResetArray(work_));
}

void FieldLayout::add_to_global(const std::vector<double>& local, Vec global) const {
  check(VecPlaceArray(work_, local.data()));
  check(DMLocalToGlobalBegin(dm_, work_, ADD_VALUES, global));
  check(DMLocalToGlobalEnd(dm_, work_, ADD_VALUES, global));
  check(VecResetArray(work_));
}

void FieldLayout::to_global(const std::vector<double>& local, Vec global) const {
  check(VecPlaceArray(work_, local.data()));
  check(DMLocalToGlobalBegin(dm_, work_, INSERT_VALUES, global));
  check(DMLocalToGlobalEnd(dm_, work_, INSERT_VALUES, global));
  check(VecResetArray(work_));
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

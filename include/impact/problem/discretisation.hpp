#pragma once
#include <impact/kernel/point_data.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/state_table.hpp>
#include <memory>
#include <string>
#include <vector>

/// Mesh, layouts and packed cells of one run: a value made by one call from a mesh, at the start, at a
/// restart and after any later change of the mesh.
namespace impact {

/// A law and the regions it fills.
struct MaterialAssignment {
  PointLaw law;
  std::vector<std::string> regions;
  std::string id{};                               ///< what the user calls it
  std::shared_ptr<const HardeningTable> points{}; ///< what the law points to
};

struct Discretisation {
  Mesh mesh;
  FieldLayout displacement; ///< dim components
  FieldLayout scalar;       ///< one component (damage, temperature)
  std::vector<MaterialAssignment> materials;
  std::vector<CellGroup> groups;
  Frame frame;
  double thickness = 1; ///< multiplies integrals of plane problems in what is reported

  int dim() const { return mesh.dim(); }
  const PointLaw& law(const CellGroup& group) const { return materials[at(group.material)].law; }
  std::size_t node_values(int components) const { return at(mesh.node_count() * components); }
  double softest_modulus() const; ///< Young's, of what deforms; infinite where nothing does
  /// Doubles of a row of `components` per quadrature point, of all groups.
  std::size_t point_values(int components) const;
  bool has_damage() const;
  bool has_fatigue() const;
  bool has_viscosity() const;
  bool has_plasticity() const;
  bool has_heat() const;          ///< every material has a heat capacity then
  bool temperature_moves() const; ///< motion sees it: expansion, softening
};

/// Throws UserError(data) when a region is unknown, a cell has no material or two. Collective.
/// `plane`: of a 2D mesh; a 3D one wants plane_strain, which is passed over.
Discretisation discretise(Mesh mesh, std::vector<MaterialAssignment> materials, Frame plane,
                          double thickness);
Discretisation discretise(Mesh mesh, std::vector<MaterialAssignment> materials, bool axisymmetric,
                          double thickness);

/// Adds the rows that the physics at hand keeps: u, v, a, phi, theta, history, drive, fatigue.
void declare_state(const Discretisation& discretisation, StateTable& table);

/// Doubles that one group needs for `components` per quadrature point: [batch][point][component][lane].
std::size_t point_values(const CellGroup& group, int components);

} // namespace impact

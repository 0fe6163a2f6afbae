#pragma once
#include <algorithm>
#include <functional>
#include <impact/kernel/point_data.hpp>
#include <impact/material/place_factors.hpp>
#include <impact/material/toughness.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/state_table.hpp>
#include <impact/problem/erosion_rule.hpp>
#include <impact/problem/volume_patches.hpp>
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
  ErosionRule erosion{};
  ToughnessFatigue fatigue{};
  ToughnessByState toughness{};
  /// Factors of a cell with its centre there [3]; empty: the law is the same everywhere.
  std::function<PlaceFactors(const double* centre)> factors{};
  /// The part of their E that an expression of the place tells; empty: the same everywhere.
  std::function<double(const double* place)> E_of_place{};
};

/// Which cells have left their bodies (erosion.hpp); empty as long as none has.
struct ErodedCells {
  std::vector<int> lanes_of; ///< [batch of all groups] bit l: the cell in lane l, padding with its cell
  std::vector<char> cell;    ///< [DMPlex cell point minus the first one] 1: it has left

  /// Those facets whose cell is still there.
  FacetTable live(const FacetTable& facets, PetscInt cell_start) const;
  int in_batch(std::size_t batch) const { return lanes_of.empty() ? 0 : lanes_of[batch]; }
};

// Functions beyond the usual: one question for each kind of physics.
struct Discretisation {
  Mesh mesh;
  FieldLayout displacement; ///< dim components
  FieldLayout scalar;       ///< one component (damage, temperature)
  std::vector<MaterialAssignment> materials;
  std::vector<CellGroup> groups;
  std::vector<PointLaw> laws; ///< of the groups
  Frame frame;
  double thickness = 1;          ///< multiplies integrals of plane problems in what is reported
  ErodedCells eroded{};          ///< at the end of the attempt at work; Erosion keeps it
  std::vector<int> weightless{}; ///< as ErodedCells::lanes_of, of cells whose mass is gone; empty: none
  bool lumped_mass = false; ///< a cell's mass stands at its nodes, by the integrals of the shape functions

  VolumePatches patches{};
  /// [patch] J over the ratio of the volumes of the cells that are left, where some have left, so that their
  /// leaving strains no other; empty: 1. Erosion keeps it.
  std::vector<double> patch_scale{};

  const std::vector<double>* mass_factor =
      nullptr;                  ///< of the row "mass_factor": mass in use over the true one
  bool lumped_capacity = false; ///< a cell's c_V stands at its nodes, as the mass does
  double depth = 1; ///< of what the mesh is a section of, in integrals: of rings 2 pi R, the mean over nodes

  int dim() const { return mesh.dim(); }
  const PointLaw& law(const CellGroup& group) const { return laws[at(group.law)]; }
  std::size_t node_values(int components) const { return at(mesh.node_count() * components); }
  std::vector<double> local_of(Vec u) const; ///< [node][dim] of a displacement or force. Collective.
  Handle<Vec> global_of(const std::vector<double>& u) const; ///< of owned nodes' [node][dim]. Collective.
  template <class Test> bool any_law(Test&& test) const {
    return std::any_of(materials.begin(), materials.end(), [&](const auto& m) { return test(m.law); });
  }
  bool has_damage() const {
    return any_law([](const PointLaw& law) { return law.parameters.damage != Damage::none; });
  }
  bool has_fatigue() const {
    return std::any_of(materials.begin(), materials.end(),
                       [](const auto& m) { return m.law.fatigues() || m.fatigue.works(); });
  }
  /// Whether points keep the energies that drive damage and what laws that soften have stored: the row
  /// "drive".
  bool has_drive() const {
    return has_damage() || any_law([](const PointLaw& law) { return law.softens(); });
  }
  /// Whether a toughness follows rate or temperature.
  bool has_toughness() const {
    return std::any_of(materials.begin(), materials.end(), [](const auto& m) { return m.toughness.works(); });
  }
  bool has_failure() const {
    return any_law([](const PointLaw& law) { return law.fails(); });
  }
  bool erodes() const {
    return std::any_of(materials.begin(), materials.end(), [](const auto& m) { return m.erosion.on; });
  }
  bool sheds_mass() const {
    return std::any_of(materials.begin(), materials.end(),
                       [](const auto& m) { return m.erosion.on && !m.erosion.keeps_mass; });
  }
  bool has_viscosity() const {
    return any_law([](const PointLaw& law) { return law.viscous(); });
  }
  bool has_plasticity() const {
    return any_law([](const PointLaw& law) { return law.flows(); });
  }
  bool has_heat() const { ///< every material has a heat capacity then
    return any_law([](const PointLaw& law) { return law.parameters.c_v > 0; });
  }
  bool conducts() const {
    return any_law([](const PointLaw& law) { return law.parameters.conductivity > 0; });
  }
  bool temperature_moves() const { ///< motion sees it: expansion, softening
    return has_heat() &&
           any_law([](const PointLaw& law) { return law.parameters.alpha_t != 0 || law.softens(); });
  }
  /// [group][batch][lane] 1: the cell lies in one of these regions.
  std::vector<char> lanes_in(const std::vector<std::string>& regions) const;
  double softest_modulus() const; ///< Young's, of what deforms; infinite where nothing does
  /// Units of what rounding leaves: h^(d-1) and h^d of the shortest edge, times depth.
  double small_facet() const;
  double small_cell() const;
  std::size_t batch_count() const; ///< of all groups
  /// Doubles of a row of `components` per quadrature point, of all groups.
  std::size_t point_values(int components) const;
};

/// Throws UserError(data) when a region is unknown, a cell has no material or two. Collective.
/// `plane`: of a 2D mesh; a 3D one wants plane_strain, which is passed over.
Discretisation discretise(Mesh mesh, std::vector<MaterialAssignment> materials, Frame plane,
                          double thickness);

/// Adds the rows that the physics at hand keeps: u, v, a, phi, theta, history, drive, fatigue, jc_failure.
void declare_state(const Discretisation& discretisation, StateTable& table);

/// f = 0 at owned local dofs of a nodal field: prescribed ones have no residual.
void zero_dofs(Vec f, const Mesh& mesh, int components, const std::vector<int>& dofs);

/// What all ranks added to the nodes of a field, on each of them. Collective.
void add_up(const FieldLayout& layout, std::vector<double>& local);

/// As printf has it.
[[gnu::format(printf, 1, 2)]] std::string text_of(const char* format, ...);
/// "(0.25, 1)": a place for messages; `format` of a number.
std::string place_text(const double* x, int dim, const char* format = "%.4g", const char* between = ", ");
/// Where the largest entry of a vector of the displacements stands, as place_text; empty if all are 0.
/// Collective.
std::string place_of_largest(const Discretisation& discretisation, Vec f);

/// Doubles that one group needs for `components` per quadrature point: [batch][point][component][lane].
std::size_t point_values(const CellGroup& group, int components);

} // namespace impact

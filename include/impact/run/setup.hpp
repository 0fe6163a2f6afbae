#pragma once
#include <impact/contact/contact_set.hpp>
#include <impact/mesh/gmsh.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <impact/run/obstacle_body.hpp>
#include <optional>

/// All that hangs on a mesh: laws, state, boundary data and contacts of a scenario, on the ranks at hand.
namespace impact {

struct Setup {
  Discretisation discretisation;
  StateTable state;
  RigidBodies rigid;
  BoundaryData boundary;
  ContactSet contacts, joints; ///< with motion; without it, of those that conduct heat
  GmshFile file;               ///< of the mesh, of each rank its part
};

/// The one way from a mesh to all that hangs on it, at the start, on a restart and after nodes have moved.
/// Its parts refer to each other, so it does not move. `obstacles`: the bodies of rigid obstacles with mass,
/// cells of the mesh already. Collective. Throws UserError.
std::unique_ptr<Setup> build_on(Mesh mesh, const Scenario& scenario,
                                const std::vector<ObstacleBody>& obstacles);

/// Reads the mesh of a scenario, builds on it, moves apart what overlaps and may be moved, and refuses what
/// no run can start from. `file`: the mesh that a checkpoint holds in place of the one that the scenario
/// names. Collective. Throws UserError.
std::unique_ptr<Setup> build_setup(MPI_Comm comm, const Scenario& scenario,
                                   std::optional<GmshFile> file = {});

/// -mesh_convert: writes the mesh of a scenario, which is checked against it, as an HDF5 file. Collective.
/// Throws UserError.
void convert_mesh(MPI_Comm comm, const Scenario& scenario);

/// Moves the secondary nodes of contacts that overlap at the start out of their primaries, contact by
/// contact, and builds everything on the mesh that this makes. What is moved may overlap something else, a
/// little, or a curved surface by the square of the way: more than one round. Collective. Throws
/// UserError(data) when that does not end, or when cells have no room for it.
void adjust_initial_overlaps(const Scenario& scenario, const std::vector<ObstacleBody>& obstacles,
                             std::unique_ptr<Setup>& setup);

/// Whether neither side of a contact can deform. Collective.
bool between_rigid_sides(const Setup& setup, const ContactSettings& contact);

/// u, v, a (of prescribed dofs) and phi at t = 0 into the state table: the initial conditions, then the
/// boundary data, which win. Collective. Throws UserError.
void set_initial_state(const Scenario& scenario, Setup& setup);

/// Velocities and accelerations, of prescribed dofs too, where a run goes on at t = `start` from the
/// checkpoint of one with another -ts_type. From statics (`from_rest`) bodies start with the velocities of
/// the initial conditions. Collective. Throws UserError where there are rigid bodies.
void set_state_of_other_scheme(const Scenario& scenario, Setup& setup, double start, bool from_rest);

} // namespace impact

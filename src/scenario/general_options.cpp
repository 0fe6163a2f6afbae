#include "classes.hpp"
#include <impact/petsc/error.hpp>

/// The options of the whole run and of its mesh.
namespace impact {

OptionGroup general_options() {
  OptionGroup group{"General", ""};
  Rows row(group.rows, RestartKey::free);
  row.text("title", &Scenario::title, "text", "printed at the head of the log and of the outputs");
  row.text("output_dir", &Scenario::output_dir, "path",
           "everything that a run writes goes below it; made if missing");
  row.flag("output_overwrite", &Scenario::overwrite,
           "a run that starts anew replaces what an earlier one left in its folder, instead of moving it to "
           "earlier_1, earlier_2, ..");
  row.restart = RestartKey::frozen;
  row.choice("units", &Scenario::units, "system of bare numbers and of everything that is written", "SI",
             *unit_system("SI"), "mm_t_s_MPa", *unit_system("mm_t_s_MPa"), "mm_kg_ms_GPa",
             *unit_system("mm_kg_ms_GPa"));
  row.count("dim", &Scenario::dim, 2, "expected dimension of the mesh", 3).otherwise("from the mesh").misfit =
      [](const Scenario& s, int dim) {
        return s.dim == dim ? std::string()
                            : "the mesh has dimension " + std::to_string(dim) +
                                  "; allowed: its dimension, or leave it out";
      };
  row.choice("plane", &Scenario::plane,
             "kind of a 2D problem: a body that cannot expand along z, a sheet that may, or a ring, where x "
             "is the radius",
             "strain", PlaneMode::strain, "stress", PlaneMode::stress, "axisymmetric",
             PlaneMode::axisymmetric)
      .refused([](const Scenario& s) { return s.dim == 3; },
               "the problem has three dimensions; allowed with -dim 2")
      .misfit = [](const Scenario&, int dim) {
    return dim == 3 ? "the mesh has dimension 3; allowed: plane meshes" : "";
  };
  row.restart = RestartKey::guarded;
  row.list("physics", &Scenario::physics,
           "balances that are solved; of what is left out, options and conditions have no effect, and "
           "without motion bodies stay where they are",
           {"motion", "damage", "heat"})
      .otherwise("motion, and what has data of damage and heat")
      .barred([](const Scenario& s) { return s.solves("heat") && !s.physics.empty() && !s.has_heat(); },
              " \"heat\": no material has a heat capacity; give -material_{material}_c_v")
      .barred([](const Scenario& s) { return s.solves("damage") && !s.physics.empty() && !s.has_damage(); },
              " \"damage\": no material has damage; give -material_{material}_damage");
  row.number("thickness", &Scenario::thickness, "m", positive,
             "of a plane problem; forces and energies are for it")
      .idle([](const Scenario& s) { return s.plane == PlaneMode::axisymmetric; },
            "-plane axisymmetric has whole rings")
      .misfit = [](const Scenario&, int dim) {
    return dim == 3 ? "the mesh has dimension 3, and its own thickness; allowed: plane meshes" : "";
  };
  row.restart = RestartKey::free;
  row.flag("dry_run", &Scenario::dry_run,
           "check everything, print the resolved input and the reports, stop; -help does so too");
  row.flag(
      "options_strict", &Scenario::strict,
      "what is without effect is refused, not only told: options of PETSc's that the solvers of this run do "
      "not read, data of laws that a material does not have");
  row.flag("test_restep", &Scenario::restep,
           "every step is solved, refused and solved again: a test of the program");
  return group;
}

OptionGroup mesh_options() {
  OptionGroup group{
      "Mesh", "`-mesh_set_<name> value` sets the constant `<name>` of a .geo file to a number or one word. A "
              ".geo file is a program: gmsh runs shell commands that stand in it (`SystemCall`), so take "
              "none from people you do not trust."};
  Rows row(group.rows, RestartKey::frozen, &Scenario::mesh);
  auto& file = row.file("mesh", &MeshScenario::file,
                        "a .msh file (4.1, 2.2), a .geo file from which gmsh makes one, or an .h5 file that "
                        "-mesh_convert wrote; a restart goes on with the mesh in its checkpoint")
                   .required();
  // A restart takes the mesh from its checkpoint and may do without the file.
  file.read = [existing = file.read](Scenario& s, const GivenOption& option, const OptionContext& context) {
    const std::string restart = option_text("restart").value_or("none");
    try {
      existing(s, option, context);
    } catch (const UserError&) {
      if (restart == "none" || option.text.empty()) throw;
      s.mesh.file = option.text;
    }
  };
  row.count("order", &MeshScenario::order, 1,
            "order of the cells. 2: displacement is quadratic, and damage and temperature are but for "
            "-damage_order and -heat_order; a .geo gives curved "
            "edges, a .msh of first order straight ones",
            2)
      .otherwise("that of the file, 1 for a .geo");
  row.flag("mesh_serendipity", &MeshScenario::serendipity,
           "-order 2 makes quadrilaterals of 8 and hexahedra of 20 nodes instead of 9 and 27")
      .refused([](const Scenario& s) { return s.mesh.serendipity && s.mesh.order != 2; },
               "it is for -order 2; a .msh of second order says by itself which nodes its cells have");
  row.number("mesh_scale", &MeshScenario::scale, "1", positive, "factor of all coordinates of the file");
  row.count("dm_refine", &MeshScenario::refine, 0,
            "uniform refinements after reading, of straight edges: a .msh or .geo of second order is refused",
            10);
  row.restart = RestartKey::free;
  row.number("mesh_cells", &MeshScenario::most_cells, "1", positive, "most cells that -dm_refine may make")
      .otherwise("2e6")
      .idle([](const Scenario& s) { return s.mesh.refine == 0; }, "-dm_refine is not given");
  row.text("mesh_convert", &MeshScenario::convert, "path",
           "the mesh is read, checked and written to this .h5 file, and no more is done. `-mesh` then reads "
           "that "
           "file in parallel, each rank a part of it; everything else, -mesh_scale and -dm_refine too, stays "
           "with "
           "the run")
      .refused([](const Scenario& s) { return !s.mesh.convert.ends_with(".h5"); },
               "allowed: a name that ends with .h5")
      .denied(
          [](const Scenario& s) { return s.checkpoint.restart != "none"; },
          "-mesh_convert and -restart: a run that converts its mesh makes no step; leave one of them out");
  row.number("mesh_wall", &MeshScenario::patience, "1", not_negative,
             "seconds on the clock after which gmsh is stopped; 0: never");
  return group;
}

} // namespace impact

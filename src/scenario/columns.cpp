#include <algorithm>
#include <impact/scenario/columns.hpp>
#include <stdexcept>

namespace impact {

namespace {

struct ColumnNote {
  const char* name;  // with words in brackets for parts that vary: reaction_<bc>_<axis>
  const char* unit;  // SI; "" for a count or ratio, "extent": m of a plane problem, else m^2
  const char* about; // one phrase: sign, reference, equation tag of src/theory.md
  int width = 0;     // on the terminal
};

constexpr const char* axes[3] = {"x", "y", "z"};
constexpr const char* pairs[6] = {"xx", "yy", "zz", "xy", "yz", "xz"};

// Energies, works and losses are of all bodies, of a plane problem for the whole -thickness, of an
// axisymmetric one of the full ring.
// The first one that fits a name describes it.
constexpr ColumnNote history[] = {
    {"step", "", "number of accepted steps since t = 0"},
    {"time", "s",
     "t; load factor with -ts_type static; that of the path with -ts_path_dissipation and -ts_path_length"},
    {"dt", "s", "length of the step that ended here"},
    {"load_parameter", "s", "the t of conditions with -ts_path_dissipation and -ts_path_length"},
    {"tries", "", "of the step: 1, and one for each time that it was cut"},
    {"newton", "", "Newton iterations of the motion in the step's last try, over all passes; so the next"},
    {"linear", "", "iterations of its linear solver; 1 for a direct solve"},
    {"uzawa", "", "solves of the motion with contact: one for each pass, and one for each augmentation"},
    {"newton_most", "", "Newton iterations of the longest solve of the step, of any try"},
    {"damage_its", "", "iterations of the damage in the step, over all passes"},
    {"heat_its", "", "iterations of the heat in the step, over all passes"},
    {"mass_added", "kg", "by -ts_mass_scaling_dt, in the kinetic energy and the momenta"},
    {"energy_kinetic", "J",
     "of all bodies, as all energies, works and losses: for the whole -thickness, of the full ring where "
     "axisymmetric"},
    {"energy_elastic", "J", "degraded by damage; 0 at the unstrained state"},
    {"energy_plastic", "J", "stored by hardening: (1 - chi) of the plastic work, (54)"},
    {"energy_fracture", "J",
     "of the cracks, by Gc (56), with Gc_rate and Gc_temperature what it was where they grew (T2)"},
    {"energy_fatigue", "J",
     "of the fatigue variable (F1), or what the toughness has lost of energy_fracture (F2); not positive"},
    {"energy_thermal", "J", "c_V (theta - theta0) + theta s, 0 at theta0 without strain (section 12)"},
    {"energy_contact", "J", "potential of what penetrates, 0 without a penalty that gives"},
    {"energy_foundation", "J", "of the springs of foundations (3'')"},
    {"energy_numerical", "J", "what the integrator holds, of any sign (N2)"},
    {"energy_<kind>_<material>", "J",
     "kinetic, elastic, plastic, fracture, fatigue or thermal energy of one material"},
    {"dissipated_viscous", "J", "since t = 0, as all losses; by viscosity (62)"},
    {"dissipated_damage", "J", "by the rate of damage (63'); 0 with c = inf"},
    {"dissipated_plastic", "J", "chi of the plastic work, and what damage and flow exchange (section 11)"},
    {"dissipated_friction", "J", "by sliding; not negative but in single explicit steps"},
    {"dissipated_fatigue", "J", "by growth of the fatigue variable (25'), by the fall of the toughness (F3)"},
    {"dissipated_contact", "J",
     "by impacts and springs that are lost, signed; negative: energy that contact gave"},
    {"dissipated_erosion", "J",
     "energy that cells which left had stored, less what stays with their nodes; with erosion_mass remove "
     "their kinetic energy, too (7)"},
    {"dissipated_foundation", "J", "by dashpots of foundations and in waves that left (3'')"},
    {"dissipated_closing", "J", "where cracks close, signed (section 7)"},
    {"dissipated_numerical", "J", "by the integrator, signed (N1), (N2)"},
    {"dissipated_<kind>_<material>", "J", "viscous, damage, plastic or fatigue loss in one material"},
    {"exchange_numerical", "J", "part of dissipated_numerical that has no sign, since t = 0 (N3)"},
    {"gain", "J", "energy that contact, closing cracks and the integrator gave, not negative (section 11)"},
    {"work_external", "J", "of loads, supports and prescribed phi on the bodies since t = 0"},
    {"work_damage", "J", "part of work_external that prescribed phi did"},
    {"work_contact", "J", "of all contact forces on all bodies since t = 0"},
    {"heat_supplied", "J",
     "that came in by conditions and from rigid bodies since t = 0; out of the bodies: negative"},
    {"heat_contact_<contact>", "J", "conducted through the contact since t = 0, into the secondary side"},
    {"entropy_produced", "J/K",
     "since t = 0: entropy less what came in; not negative with -heat_form entropy"},
    {"balance", "",
     "identity of the integrator over the largest energy so far: rounding in every run (section 11)"},
    {"balance_first_law", "",
     "stored + dissipated - work - heat supplied - start, over the largest energy so far; falls with the "
     "step"},
    {"coupling_error", "",
     "with -coupling_error: forces that the end's phi and theta would change, over all internal ones"},
    {"phi_max", "", "largest phi at a node"},
    {"alpha_max", "", "largest plastic strain at a point of a cell"},
    {"theta_max", "K", "largest temperature at a node, absolute"},
    {"theta_min", "K", "smallest temperature at a node, absolute"},
    {"fatigue_max", "N/m",
     "largest fatigue variable: of (F1) at a point, broken at Gc; of (F2) in a cell, gamma times the summed "
     "energy"},
    {"eroded_cells", "", "number of cells that have left since t = 0"},
    {"eroded_mass", "kg",
     "their mass, of a plane problem times the thickness; it stays with their nodes unless erosion_mass says "
     "remove"},
    {"eroded_momentum_<axis>", "N.s", "that went with mass that cells took along (erosion_mass remove)"},
    {"jc_failure_max", "", "largest failure measure at a point, failed at 1 (55d)"},
    {"reaction_<bc>_<axis>", "N",
     "force of the support on the bodies, over the condition's group, or of the guide on obstacle_<contact> "
     "(section 11)"},
    {"moment_<bc>_<axis>", "N.m",
     "of the support on rigid bodies about their centres of mass; mean over the step with inertia"},
    {"heat_<bc>", "J", "that came in by a thermal condition since t = 0; out: negative"},
    {"mean_<bc>_theta", "K", "temperature over the nodes of a thermal condition, each counts alike"},
    {"mean_<bc>_u<axis>", "m", "displacement over the nodes of the condition's group, each counts alike"},
    {"contact_<contact>_force_<axis>", "N", "on the secondary side, at the end of the step"},
    {"contact_<contact>_gap_min", "m",
     "least gap of what faces something: open positive, overlap negative (71'); nan: nothing does"},
    {"contact_<contact>_pressure_max", "Pa",
     "per current area (in a sheet, -plane stress, of its first thickness); pressing is positive; nodes of "
     "linear tetrahedra scatter about what they approach, by 7 % where seven facets, 4 % where fourteen lie "
     "over the radius of a Hertz contact"},
    {"contact_<contact>_pressure_min", "Pa", "least pressure of what presses; 0 without"},
    {"contact_<contact>_active", "", "constraints (Gauss points, or nodes of the mortar) that press"},
    {"contact_<contact>_length", "extent",
     "closed part of the secondary side: current length of a plane problem (thickness apart), else area"},
    {"contact_<contact>_work", "J", "of this contact's forces on both bodies since t = 0"},
    {"contact_<contact>_sliding", "", "active constraints that slide against friction"},
    {"contact_<contact>_dissipated", "J", "by their sliding since t = 0"},
    {"impulse_<contact>_<axis>", "N.s", "of the contact's forces on the secondary side since t = 0"},
    {"rigid_<body>_u<axis>", "m", "displacement of the centre of mass of a rigid body since t = 0"},
    {"rigid_<body>_r<axis>", "rad",
     "rotation vector since t = 0; of a plane body the angle, whole turns counted, anticlockwise positive"},
    {"rigid_<body>_v<axis>", "m/s", "velocity of the centre of mass"},
    {"rigid_<body>_w<axis>", "rad/s", "angular velocity about fixed axes"},
    {"rigid_<body>_l<axis>", "kg.m^2/s", "angular momentum about the centre of mass"},
    {"momentum_<material>_<axis>", "N.s", "of the bodies of a material"},
    {"spin_<material>_<axis>", "N.m.s",
     "their angular momentum about the origin, in the plane about z; not of rings"},
    {"crack_<material>_count", "",
     "cracks there are: sets of nodes with phi above -crack_level that cells join"},
    {"crack_<material>_<n>_origin_<axis>", "m",
     "of the n-th crack, as of the first below; n from 2 to -crack_tips"},
    {"crack_<material>_<n>_tip_<axis>", "m",
     "of the n-th crack; nan before it is there and after an older one has met it"},
    {"crack_<material>_<n>_speed", "m/s", "of the tip of the n-th crack"},
    {"crack_<material>_origin_<axis>", "m",
     "where the first crack began, reference place: its node with the largest phi a step before; nan "
     "without"},
    {"crack_<material>_tip_<axis>", "m",
     "its node farthest from the origin, reference place; nan without a crack"},
    {"crack_<material>_speed", "m/s",
     "of that tip over its last way of at least 2 gamma, and less the longer it stands; nan without a crack"},
    {"crack_<material>_measure", "extent",
     "energy_fracture of the material over Gc: length of a plane problem (thickness apart), else area"},
    {"probe_<probe>_<field>", "", "field at a material point, unit and components as below"},
    {"release_<release>", "N/m",
     "energy release rate of the crack in the ring or ball, elastic energy by area, with inertia what waves "
     "carry "
     "(J1)"},
    {"measure_<measure>_<field>", "", "mean, least, largest or sum of a field over the nodes of a group"},
};

constexpr ColumnNote terminal[] = {
    {"step", "", "as in the history", 8},
    {"t", "s", "time", 12},
    {"dt", "s", "as in the history", 10},
    {"try", "", "tries", 3},
    {"newt", "", "newton", 4},
    {"linear", "", "as in the history", 6},
    {"dam", "", "damage_its", 4},
    {"uz", "", "uzawa", 3},
    {"act", "", "active constraints of all contacts", 4},
    {"max phi", "", "phi_max", 8},
    {"max alpha", "", "alpha_max", 9},
    {"1st law", "", "balance_first_law", 10},
    {"wall", "m:ss", "on the clock since the start of the program", 8},
    {"left", "m:ss", "until -ts_max_time, at the speed so far", 8},
};

constexpr FieldNote fields[] = {
    {"u", 3, true, "m", "displacement since the reference place"},
    {"v", 3, true, "m/s", "velocity"},
    {"a", 3, true, "m/s^2",
     "acceleration; with -ts_newmark_rho 1 by the mean of the forces of stabilised contact and closing "
     "cracks over the step"},
    {"phi", 1, true, "", "damage: 0 sound, 1 broken"},
    {"theta", 1, true, "K", "absolute temperature"},
    {"stress", 6, false, "Pa",
     "Cauchy stress without its viscous part, mean over the cell, tension positive"},
    {"von_mises", 1, false, "Pa", "of the mean stress of the cell"},
    {"alpha", 1, false, "", "plastic strain, mean over the cell"},
    {"pressure", 1, false, "Pa", "minus a third of the trace of the stress, compression positive"},
    {"fatigue", 1, false, "N/m",
     "fatigue variable, mean over the cell (F1), gamma times the summed energy (F2)"},
    {"E", 1, false, "Pa", "Young's modulus of the cell, by E_factor and E_weibull"},
    {"Gc", 1, false, "N/m",
     "toughness of the cell without what fatigue took and without factors of rate and temperature, by "
     "Gc_factor and Gc_weibull"},
    {"strength", 1, false, "Pa",
     "strength of the cell (56''), by strength_factor and strength_weibull; 0: none"},
    {"jc_failure", 1, false, "", "failure measure, mean over the cell, failed at 1 (55d)"},
    {"eroded", 1, false, "", "1 where the cell has left its body, which a viewer may hide"},
    {"contact_pressure", 1, true, "Pa",
     "per current area (in a sheet of its first thickness), pressing positive; 0 off the surface"},
    {"contact_gap", 1, true, "m", "open positive; nan where nothing is near"},
    {"contact_status", 1, true, "", "0 open, 1 sticks, 2 slides or presses without friction"},
    {"contact_traction", 3, true, "Pa", "of friction on the secondary side, per that area"},
    {"contact_slip", 3, true, "m", "of the secondary side since the place closed"},
};

// Brackets stand for one or more letters, digits and underscores, <axis> for one of x, y, z.
bool fits(std::string_view pattern, std::string_view name) {
  if (pattern.empty() || name.empty()) return pattern.empty() && name.empty();
  if (pattern[0] != '<') return pattern[0] == name[0] && fits(pattern.substr(1), name.substr(1));
  const std::size_t end = pattern.find('>');
  if (pattern.substr(0, end) == "<axis")
    return name[0] >= 'x' && name[0] <= 'z' && fits(pattern.substr(end + 1), name.substr(1));
  for (std::size_t n = 1; n <= name.size(); ++n)
    if (fits(pattern.substr(end + 1), name.substr(n))) return true;
  return false;
}

std::string field_unit(std::string_view column) {
  for (const FieldNote& field : fields)
    for (int k = 0; k < field.components; ++k)
      if (column.ends_with("_" + component_name(field.name, k, field.components))) return field.unit;
  throw std::logic_error("history: the field of column " + std::string(column) + " is not described");
}

std::string table(const char* what, std::span<const ColumnNote> notes) {
  std::string page = std::string("| ") + what + " | SI unit | meaning |\n|---|---|---|\n";
  for (const ColumnNote& note : notes) {
    const std::string unit = note.unit;
    page += std::string("| `") + note.name + "` | " + (unit == "extent" ? "m or m^2" : unit) + " | " +
            note.about + " |\n";
  }
  return page;
}

} // namespace

std::string terminal_heads() {
  std::string text;
  for (const ColumnNote& note : terminal) {
    const std::string head = note.name;
    text += (text.empty() ? "" : " ") + std::string(static_cast<std::size_t>(note.width) - head.size(), ' ') +
            head;
  }
  return text;
}

std::span<const FieldNote> field_notes() { return fields; }

std::string component_name(const std::string& field, int component, int components) {
  if (components == 1) return field;
  return components == 6 ? field + "_" + pairs[component] : field + axes[component];
}

std::string column_unit(const std::string& column, const UnitSystem& units, bool plane) {
  const auto note = std::ranges::find_if(history, [&](const ColumnNote& n) { return fits(n.name, column); });
  if (note == std::end(history)) throw std::logic_error("history: column " + column + " is not described");
  std::string unit = note->unit;
  if (std::string_view(note->name).ends_with("<field>")) unit = field_unit(column);
  if (unit == "extent") unit = plane ? "m" : "m^2";
  if (unit.empty()) return "";
  if (units.name == "SI") return " [" + unit + "]";
  const std::string symbol = unit_symbol(parse_unit(unit).dimension, units);
  return symbol == "1" ? " [" + unit + "]" : " [" + symbol + "]";
}

std::string column_reference() {
  std::string page = "### Columns of the history\n\nNames in angle brackets are ids and components; `<body>` "
                     "is a rigid body or obstacle, `<kind>` a "
                     "kind of energy or loss. Tags and sections are those of "
                     "src/theory.md. A column is there when the run has what it tells of. The header line "
                     "has the unit of the run's system behind each name.\n\n" +
                     table("column", history);
  page += "\n### Columns of the terminal\n\n" + table("head", terminal);
  page += "\n### Fields\n\nOf outputs, probes and measures. Three components are x, y, z (in field files 0 "
          "for z of a plane problem; "
          "columns `ux`, `uy`); six are xx, yy, zz, xy, yz, xz, in that order (columns `stress_xx` ..); in "
          "axisymmetric problems x is the radius, "
          "y the axis and zz around it.\n\n"
          "| field | on | components | SI unit | meaning |\n|---|---|---|---|---|\n";
  for (const FieldNote& field : fields)
    page += std::string("| `") + field.name + "` | " + (field.on_nodes ? "nodes" : "cells") + " | " +
            std::to_string(field.components) + " | " + field.unit + " | " + field.about + " |\n";
  return page;
}

} // namespace impact

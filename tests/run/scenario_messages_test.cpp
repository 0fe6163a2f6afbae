#include "scenario_options.hpp"
#include <gtest/gtest.h>

namespace {

using namespace scenario_options;
using impact::ExitCode;

struct Row {
  Options changes;
  ExitCode code;
  std::string message;
};

// Changes that give the beam damage, and more of them.
Options damaged(Options more) {
  more.insert(
      {{"-material_beam_damage", "at2"}, {"-material_beam_Gc", "5 kN/m"}, {"-material_beam_gamma", "1 mm"}});
  return more;
}

// Changes that give the beam a strength of its own, E G_c/f_t^2 = 0.8 m, and more of them.
Options cohesive(Options more) {
  more.insert({{"-material_beam_damage", "wu"},
               {"-material_beam_ge", "cornelissen"},
               {"-material_beam_strength", "3 MPa"},
               {"-material_beam_Gc", "100 N/m"},
               {"-material_beam_gamma", "5 mm"},
               {"-material_beam_split", "volumetric"}});
  return more;
}

// Changes that give the beam an equation of state, and more of them.
Options pressed(Options more) {
  more.insert({{"-material_beam_E", "-"},
               {"-material_beam_nu", "-"},
               {"-material_beam_G", "47 GPa"},
               {"-material_beam_eos", "mie_grueneisen"},
               {"-material_beam_eos_c0", "3940 m/s"},
               {"-material_beam_eos_s", "1.489"}});
  return more;
}

const std::vector<Row>& rows() {
  static const std::vector<Row> all = {
      {{{"-material_beam_Gcc", "1"}},
       ExitCode::usage,
       "unknown option -material_beam_Gcc; did you mean -material_beam_Gc?   (materials: beam, wedge)"},
      {{{"-bc_push_uy", "0.1*sin(2*p*t)"}},
       ExitCode::usage,
       "-bc_push_uy \"0.1*sin(2*p*t)\": unknown name 'p' at character 10; known: x y z t pi e v0 load(); "
       "functions: abs acos acosh asin asinh atan atan2 atanh avg cos cosh cycle exp ln log log10 log2 max "
       "min pulse ramp rint sign sin sinh sqrt step sum tan tanh"},
      {{{"-material_baem_E", "1"}},
       ExitCode::usage,
       "unknown option -material_baem_E; did you mean -material_beam_E?   (materials: beam, wedge)"},
      {{{"-material_rod_E", "1"}},
       ExitCode::usage,
       "unknown option -material_rod_E   ('rod' is not declared; materials: beam, wedge)"},
      {{{"-motion_kps_type", "cg"}},
       ExitCode::usage,
       "unknown option -motion_kps_type; did you mean -motion_ksp_type?   (after -motion_: "
       "leave_unstable, mat_type, reuse_preconditioner, reuse_tangent, tangent, and PETSc's options of "
       "solvers)"},
      {{{"-heat_foo", "1"}},
       ExitCode::usage,
       "unknown option -heat_foo; did you mean -heat_form?   (after -heat_: capacity, form, order, theta, "
       "ts_dt, and "
       "PETSc's options of solvers)"},
      {{{"-heat_ts_dt", "abc"}},
       ExitCode::usage,
       "-heat_ts_dt \"abc\": not a number; allowed: a number in s, or one with a unit of that kind"},
      {{{"-damage_ts_dt", "0"}}, ExitCode::usage, "-damage_ts_dt \"0\": out of range; allowed: > 0 s"},
      {{{"-damage_bound", "vi"}},
       ExitCode::usage,
       "unknown option -damage_bound; did you mean -damage_bounds?   (after -damage_: bounds, every, form, "
       "order, "
       "substeps, theta, ts_dt, and PETSc's options of solvers)"},
      {{{"-stops", "broken"}, {"-stop_end_when", "-"}},
       ExitCode::usage,
       "-stop_broken_when: missing; allowed: condition on columns by name; it is what ends the run, as in "
       "reaction_top_y < "
       "0.1*peak(reaction_top_y): an expression of columns of the history and of parameters"},
      {{{"-stops", "broken"}, {"-stop_broken_when", "peak(peak(t)) > 1"}, {"-stop_end_when", "-"}},
       ExitCode::usage,
       "-stop_broken_when \"peak(peak(t)) > 1\": a peak in a peak; allowed: peak(name)"},
      {{{"-output_vis_cycles", "10"}},
       ExitCode::usage,
       "-output_vis_cycles \"10\": counts the cycles of a load whose period is not given; add -ts_period, or "
       "remove "
       "it"},
      {{{"-material_beam_damage", "at2"},
        {"-material_beam_Gc", "1"},
        {"-material_beam_gamma", "1"},
        {"-material_beam_fatigue_a", "1"},
        {"-damage_bounds", "history"}},
       ExitCode::usage,
       "-damage_bounds \"history\": lets the fatigue of -material_beam_fatigue_a drive phi beyond 1; allowed "
       "with "
       "fatigue: vi, clip"},
      {{{"-material_beam_damage", "at2"},
        {"-material_beam_Gc", "1"},
        {"-material_beam_gamma", "1"},
        {"-material_beam_fatigue", "asymptotic"}},
       ExitCode::usage,
       "-material_beam_fatigue \"asymptotic\": the stress of the crack energy knows no toughness that "
       "changes; "
       "allowed with -material_beam_damage_gradient material, or -material_beam_fatigue power"},
      {{{"-material_beam_damage", "at2"},
        {"-material_beam_Gc", "1"},
        {"-material_beam_gamma", "1"},
        {"-material_beam_damage_gradient", "material"},
        {"-material_beam_fatigue", "logarithmic"}},
       ExitCode::usage,
       "-material_beam_fatigue_kappa: missing; -material_beam_fatigue logarithmic needs it"},
      {{{"-material_beam_damage", "at2"},
        {"-material_beam_Gc", "1"},
        {"-material_beam_gamma", "1"},
        {"-material_beam_strength_factor", "1+x"}},
       ExitCode::usage,
       "-material_beam_strength_factor \"1+x\": has no effect with -material_beam_ge quadratic: E, Gc and "
       "gamma "
       "tell the strength; allowed with linear, exponential, cornelissen or lorentz"},
      {{{"-ts_static_start", "1"}}, ExitCode::usage, "-ts_static_start \"1\": not available; remove it"},
      {{{"-order", "3"}}, ExitCode::usage, "-order \"3\": out of range; allowed: a whole number from 1 to 2"},
      {{{"-contact_operatro", "shell"}},
       ExitCode::usage,
       "unknown option -contact_operatro; did you mean -contact_operator?"},
      {{{"-ts_tpye", "static"}}, ExitCode::usage, "unknown option -ts_tpye; did you mean -ts_type?"},
      {{{"-material_beam_E", "72 GPs"}},
       ExitCode::usage,
       "-material_beam_E \"72 GPs\": unknown unit 'GPs'; allowed: a number in Pa, or one with a unit of that "
       "kind"},
      {{{"-material_beam_E", "72e9 m"}},
       ExitCode::usage,
       "-material_beam_E \"72e9 m\": 'm' has the wrong dimension; allowed: a number in Pa, or one with a "
       "unit of that kind"},
      {{{"-material_beam_nu", "0.7"}},
       ExitCode::usage,
       "-material_beam_nu \"0.7\": out of range; allowed: -1 < value < 0.5"},
      {{{"-material_beam_model", "viscoplastic"}},
       ExitCode::usage,
       "-material_beam_model \"viscoplastic\": not available; allowed: elastic, j2, rigid"},
      {{{"-material_beam_model", "rigid"}},
       ExitCode::usage,
       "-material_beam_E: has no meaning with -material_beam_model rigid; allowed: region, rho; remove it"},
      {{{"-material_beam_split", "masonry"}},
       ExitCode::usage,
       "-material_beam_split \"masonry\": not available; allowed: auto, volumetric, none, spectral, "
       "star_convex, no_tension, drucker_prager"},
      {{{"-material_beam_damage", "at3"}},
       ExitCode::usage,
       "-material_beam_damage \"at3\": not available; allowed: none, at2, at1, wu; did you mean at2?"},
      {damaged({{"-material_beam_split", "no_tension"},
                {"-material_beam_model", "j2"},
                {"-material_beam_sigma_y", "1e8"}}),
       ExitCode::usage,
       "-material_beam_split \"no_tension\": not available with -material_beam_model j2: cracks that open as "
       "they like and flow are two inelastic strains, and nothing says how they share a deformation; "
       "allowed: -material_beam_model elastic; choose spectral, volumetric or star_convex"},
      {damaged({{"-material_beam_split", "drucker_prager"}}), ExitCode::usage,
       "-material_beam_strength_ratio: missing; -material_beam_split drucker_prager needs it"},
      {damaged({{"-material_beam_split", "drucker_prager"}, {"-material_beam_strength_ratio", "1.01"}}),
       ExitCode::usage,
       "-material_beam_strength_ratio \"1.01\": is not above that of a body whose volume alone is kept under "
       "pressure, 1.062 with its nu; allowed: more than that; remedy: -material_beam_split volumetric"},
      {damaged({{"-material_beam_split", "star_convex"}}), ExitCode::usage,
       "-material_beam_star_gamma: missing; -material_beam_split star_convex needs it"},
      {damaged(
           {{"-material_beam_star_gamma", "2"}, {"-material_beam_split", "none"}, {"-options_strict", ""}}),
       ExitCode::usage,
       "without effect, because -material_beam_split is not star_convex: -material_beam_star_gamma "
       "(-options_strict)"},
      {damaged({{"-material_beam_split", "star_convex"},
                {"-material_beam_star_gamma", "2"},
                {"-damage_bounds", "history"}}),
       ExitCode::usage,
       "-damage_bounds: only the bounds of vi keep -material_beam_split star_convex from damage below 0, "
       "because compression drives it backwards; allowed: vi"},
      {damaged({{"-material_beam_split", "spectral"},
                {"-material_beam_model", "elastic"},
                {"-material_beam_nu", "-0.2"}}),
       ExitCode::usage,
       "-material_beam_split \"spectral\": with nu < 0 its tensile part can be negative; allowed: nu >= 0; "
       "choose "
       "volumetric"},
      {damaged({{"-material_beam_damage", "at1"}, {"-damage_bounds", "clip"}}), ExitCode::usage,
       "-damage_bounds: only the bounds of vi keep -material_beam_damage at1 from damage below 0; allowed: "
       "vi"},
      {cohesive({{"-damage_bounds", "history"}}), ExitCode::usage,
       "-damage_bounds: only the bounds of vi keep -material_beam_damage wu from damage below 0; allowed: "
       "vi"},
      {cohesive({{"-material_beam_ge", "quadratic"}, {"-material_beam_strength", "-"}}), ExitCode::usage,
       "-material_beam_damage \"wu\": wants a degradation that knows the strength; allowed with "
       "-material_beam_ge linear, exponential or cornelissen"},
      {cohesive({{"-material_beam_ge", "lorentz"}, {"-material_beam_damage", "at2"}}), ExitCode::usage,
       "-material_beam_ge \"lorentz\": goes with another crack model; allowed: -material_beam_damage at1"},
      {cohesive({{"-material_beam_damage", "at1"}}), ExitCode::usage,
       "-material_beam_ge \"cornelissen\": goes with another crack model; allowed: -material_beam_damage wu"},
      {cohesive({{"-material_beam_strength", "-"}}), ExitCode::usage,
       "-material_beam_strength: missing; -material_beam_ge cornelissen needs it"},
      {damaged({{"-material_beam_strength", "3 MPa"}}), ExitCode::usage,
       "-material_beam_strength \"3e+06\": has no effect with -material_beam_ge quadratic: E, Gc and gamma "
       "tell "
       "the strength; remove it, or add -material_beam_damage wu and -material_beam_ge linear, exponential "
       "or "
       "cornelissen, or -material_beam_damage at1 and -material_beam_ge lorentz"},
      {cohesive({{"-material_beam_lorentz_p", "2"}, {"-options_strict", ""}}), ExitCode::usage,
       "without effect, because -material_beam_ge is not lorentz: -material_beam_lorentz_p "
       "(-options_strict)"},
      {cohesive({{"-material_beam_gamma", "1 m"}}), ExitCode::usage,
       "-material_beam_gamma \"1\": is too long for -material_beam_strength 3e+06 with -material_beam_ge "
       "cornelissen: what reaches it would break at once; allowed: at most 0.2620643294710636, better a "
       "fifth of that"},
      {damaged({{"-material_beam_ge", "ductile"},
                {"-material_beam_model", "elastic"},
                {"-material_beam_alpha_c", "0.1"}}),
       ExitCode::usage,
       "-material_beam_ge \"ductile\": nothing damages without plastic strain; allowed with "
       "-material_beam_model "
       "j2; choose quadratic or cubic"},
      {damaged({{"-material_beam_ge", "ductile"}}), ExitCode::usage,
       "-material_beam_alpha_c: missing; -material_beam_ge ductile needs it"},
      {damaged({{"-material_beam_plastic_threshold", "1e6"}, {"-options_strict", ""}}), ExitCode::usage,
       "without effect, because -material_beam_gp is not ge: -material_beam_plastic_threshold "
       "(-options_strict)"},
      {damaged({{"-material_beam_plastic_threshold", "1e6"},
                {"-material_beam_gp", "ge"},
                {"-material_beam_model", "j2"},
                {"-material_beam_sigma_y", "1e8"},
                {"-material_beam_c_v", "1e6"},
                {"-material_beam_softening", "linear"},
                {"-material_beam_softening_w", "1e-3"}}),
       ExitCode::usage,
       "-material_beam_plastic_threshold \"1e+06\": not available with -material_beam_softening, whose "
       "plastic "
       "energy is a sum over the steps; allowed: 0, or softening none"},
      {{{"-plane", "stress"}, {"-material_beam_locking", "mean"}},
       ExitCode::usage,
       "-material_beam_locking \"mean\": has no meaning with -plane stress, where the volume is free; "
       "allowed: auto, none"},
      {{{"-material_beam_nu", "-"}},
       ExitCode::usage,
       "-material_beam_nu: missing; give -material_beam_E and -material_beam_nu, or -material_beam_K and "
       "-material_beam_G"},
      {{{"-material_beam_rho", "-"}},
       ExitCode::usage,
       "-material_beam_rho: missing; needed by inertia; or run without it: -ts_type static"},
      {{{"-material_beam_model", "j2"}},
       ExitCode::usage,
       "-material_beam_sigma_y: missing; -material_beam_model j2 needs a yield stress"},
      {{{"-material_beam_damage", "at2"}, {"-material_beam_Gc", "5 kN/m"}},
       ExitCode::usage,
       "-material_beam_gamma: missing; -material_beam_damage needs it"},
      {{{"-material_beam_model", "j2"},
        {"-material_beam_sigma_y", "3e8"},
        {"-material_beam_hardening", "voce"}},
       ExitCode::usage,
       "-material_beam_voce_r: missing; a positive value is needed by -material_beam_hardening voce"},
      {{{"-material_beam_model", "j2"}, {"-material_beam_sigma_y", "3e8"}, {"-material_beam_voce_r", "1e8"}},
       ExitCode::usage,
       "-material_beam_voce_s: missing; a positive value is needed by -material_beam_voce_r"},
      {{{"-material_beam_model", "j2"},
        {"-material_beam_jc_a", "3e8"},
        {"-material_beam_jc_b", "3e8"},
        {"-material_beam_hardening", "johnson_cook,voce"}},
       ExitCode::usage,
       "-material_beam_hardening johnson_cook,voce: johnson_cook stands alone; remove voce"},
      {{{"-material_beam_model", "j2"},
        {"-material_beam_sigma_y", "3e8"},
        {"-material_beam_jc_a", "3e8"},
        {"-material_beam_jc_b", "3e8"},
        {"-material_beam_hardening", "johnson_cook"}},
       ExitCode::usage,
       "-material_beam_sigma_y: has no meaning with -material_beam_hardening johnson_cook, which tells the "
       "yield "
       "stress itself; remove it"},
      {{{"-material_beam_model", "j2"}, {"-material_beam_hardening", "table"}},
       ExitCode::usage,
       "-material_beam_hardening_table: missing; needed by -material_beam_hardening table"},
      {{{"-material_beam_model", "j2"}, {"-material_beam_sigma_y", "3e8"}, {"-material_beam_jc_c", "0.01"}},
       ExitCode::usage,
       "-material_beam_jc_rate0: missing; a rate is needed by -material_beam_jc_c"},
      {{{"-material_beam_model", "j2"},
        {"-material_beam_sigma_y", "3e8"},
        {"-material_beam_softening", "linear"}},
       ExitCode::usage,
       "-material_beam_softening_w: missing; a positive value is needed by -material_beam_softening linear"},
      {{{"-material_beam_like", "wedge"}},
       ExitCode::usage,
       "-material_wedge_like \"beam\": goes round in a circle: beam, wedge, beam"},
      {{{"-material_wedge_like", "rod"}},
       ExitCode::usage,
       "-material_wedge_like \"rod\": no such material; allowed: beam, wedge"},
      {{{"-material_wedge_region", "beam"}},
       ExitCode::usage,
       "-material_wedge_region \"beam\": is made of material beam already; give each region to one material"},
      {{{"-bc_push_on", "-"}},
       ExitCode::usage,
       "-bc_push_on: missing; allowed: comma list of names; it is groups of the mesh: boundaries, points, or "
       "regions with all "
       "their nodes"},
      {{{"-bc_push_type", "pressure"}},
       ExitCode::usage,
       "-bc_push_uy \"1e-3*t\": has no meaning for this type; remove it, -bc_push_value is what it takes"},
      {{{"-bc_push_uy", "-"}},
       ExitCode::usage,
       "-bc_push_ux: missing; allowed: at least one of -bc_push_ux, -bc_push_uy, -bc_push_uz"},
      {{{"-bc_push_uy", "1 s"}},
       ExitCode::usage,
       "-bc_push_uy \"1 s\": 's' has the wrong dimension; allowed: a number in m, or one with a unit of that "
       "kind"},
      {{{"-ts_dt", "-"}},
       ExitCode::usage,
       "-ts_dt: missing; allowed: a time step > 0 (auto is for central differences); or give -ts_times and "
       "-ts_dts"},
      {{{"-ts_times", "0,1,2"}, {"-ts_dts", "0.1"}},
       ExitCode::usage,
       "-ts_dts \"0.1\": 1 steps for 3 times; allowed: one step less than times, of which the first is that "
       "of the start "
       "(-ts_times 0,1 -ts_dts 0.1)"},
      {{{"-ts_times", "0,2,1"}, {"-ts_dts", "0.1,0.1"}},
       ExitCode::usage,
       "-ts_times \"0,2,1\": not increasing; allowed: increasing times"},
      {{{"-motion_mat_type", "sbaij"}, {"-material_beam_model", "j2"}, {"-material_beam_sigma_y", "1 MPa"}},
       ExitCode::usage,
       "-motion_mat_type \"sbaij\": needs a symmetric tangent, that of -material_beam_model j2 is not; "
       "allowed: "
       "elastic materials without F-bar; add -motion_tangent symmetric, or choose -motion_mat_type aij"},
      {{{"-motion_mat_type", "sbaij"}, {"-motion_tangent", "symmetric"}, {"-contact_tip_friction", "0.1"}},
       ExitCode::usage,
       "-motion_mat_type \"sbaij\": needs a symmetric tangent, that of -contact_tip_friction is not; "
       "allowed: no "
       "friction; choose -motion_mat_type aij"},
      {{{"-contact_tip_rigid_ux", "1"}},
       ExitCode::usage,
       "-contact_tip_rigid_ux \"1\": `beam_bottom` is a boundary of the mesh, which moves as its body does; "
       "allowed: with plane, rigid_sphere, rigid_cylinder as the primary; remove it"},
      {{{"-ics", "fly,rest"}, {"-ic_rest_on", "beam"}},
       ExitCode::usage,
       "-ic_rest_on \"beam\": begins with nothing: no value is given; allowed: beside -ic_rest_ux .., "
       "-ic_rest_vx .., -ic_rest_phi or -ic_rest_theta"},
      {{{"-stops", "end"}, {"-stop_end_when", "reaction_push_y"}},
       ExitCode::usage,
       "-stop_end_when \"reaction_push_y\": compares nothing; allowed: comparisons, as in reaction_top_y < "
       "0.1"},
      {{{"-contact_tip_rigid_mass", "1"}},
       ExitCode::usage,
       "-contact_tip_rigid_mass \"1\": `beam_bottom` is a boundary of the mesh; allowed: with plane, "
       "rigid_sphere, rigid_cylinder as the primary; a meshed body has the mass of its material"},
      {{{"-contact_tip_primary", "plane"}, {"-contact_tip_rigid_mass", "0"}},
       ExitCode::usage,
       "-contact_tip_rigid_mass \"0\": out of range; allowed: > 0 kg"},
      {{{"-contact_tip_primary", "plane"}, {"-contact_tip_rigid_inertia", "1"}},
       ExitCode::usage,
       "-contact_tip_rigid_inertia: is for a rigid body with mass; give -contact_tip_rigid_mass, or remove "
       "it"},
      {{{"-contact_tip_primary", "plane"}, {"-contact_tip_rigid_rz", "t"}},
       ExitCode::usage,
       "-contact_tip_rigid_rz: is for a rigid body with mass; give -contact_tip_rigid_mass (any, where all "
       "of its motion is told), or remove it"},
      {{{"-contact_tip_primary", "plane"},
        {"-contact_tip_rigid_mass", "1"},
        {"-contact_tip_rigid_length", "1"}},
       ExitCode::usage,
       "-contact_tip_rigid_length \"1\": `plane` has none; allowed: with rigid_cylinder; remove it"},
      {{{"-contact_tip_primary", "plane"},
        {"-contact_tip_rigid_mass", "1"},
        {"-material_beam_c_v", "1000"},
        {"-material_wedge_c_v", "1000"}},
       ExitCode::usage,
       "-contact_tip_rigid_mass \"1\": not available with heat; allowed: runs without; mesh the body, or "
       "prescribe its motion"},
      {{{"-contact_tip_primary", "plane"}, {"-contact_tip_rigid_mass", "1"}, {"-contact_operator", "shell"}},
       ExitCode::usage,
       "-contact_operator \"shell\": not with the rigid body of -contact_tip_rigid_mass; allowed: assembled, "
       "the default"},
      {{{"-contact_tip_primary", "plane"},
        {"-contact_tip_rigid_mass", "1"},
        {"-motion_mat_type", "sbaij"},
        {"-motion_tangent", "symmetric"}},
       ExitCode::usage,
       "-motion_mat_type \"sbaij\": needs a symmetric tangent, that of -contact_tip_rigid_mass is not; "
       "allowed: rigid bodies that move as told; choose -motion_mat_type aij"},
      {{{"-motion_mat_type", "sbaij"},
        {"-motion_tangent", "symmetric"},
        {"-bc_push_type", "pressure"},
        {"-bc_push_uy", "-"},
        {"-bc_push_value", "1"}},
       ExitCode::usage,
       "-motion_mat_type \"sbaij\": needs a symmetric tangent, that of -bc_push_type pressure is not; "
       "allowed: "
       "dead loads; choose -motion_mat_type aij"},
      {{{"-materials", "beam,Beam"}},
       ExitCode::usage,
       "-materials \"beam,Beam\": 'Beam' is declared twice; ids are unique, whatever their case"},
      {{{"-materials", "beam,my_wedge"}},
       ExitCode::usage,
       "-materials \"beam,my_wedge\": 'my_wedge' is no id; allowed: lower-case letters and digits, no "
       "underscore"},
      {{{"-materials", "beam,ksp"}},
       ExitCode::usage,
       "-materials \"beam,ksp\": 'ksp' is a reserved word; choose another id"},
      {{{"-params", "v0,t"}, {"-param_t", "1"}},
       ExitCode::usage,
       "-params \"v0,t\": 't' has a meaning in expressions already; choose another id"},
      {{{"-mesh", "no/such.msh"}},
       ExitCode::io,
       "-mesh \"no/such.msh\": no such file; looked for no/such.msh"},
      {{{"-output_vis_fields", "u,vonmises"}},
       ExitCode::usage,
       "-output_vis_fields \"u,vonmises\": 'vonmises' is not available; allowed: u, v, a, phi, theta, "
       "stress, "
       "von_mises, alpha, "
       "pressure, fatigue, E, Gc, strength, jc_failure, eroded, contact_pressure, contact_gap, "
       "contact_status, "
       "contact_traction, "
       "contact_slip; "
       "did you "
       "mean von_mises?"},
      {{{"-physics", "motion,heat"}},
       ExitCode::usage,
       "-physics \"heat\": no material has a heat capacity; give -material_beam_c_v"},
      {{{"-physics", "motion,damage"}},
       ExitCode::usage,
       "-physics \"damage\": no material has damage; give -material_beam_damage"},
      {{{"-bc_push_type", "temperature"}, {"-bc_push_uy", "-"}, {"-bc_push_value", "300"}},
       ExitCode::usage,
       "-bc_push_type: acts on the temperature, and no material has a heat capacity; give "
       "-material_beam_c_v, or "
       "remove it"},
      {{{"-bc_push_type", "damage"}, {"-bc_push_uy", "-"}, {"-bc_push_value", "1"}},
       ExitCode::usage,
       "-bc_push_type: acts on the damage, and no material has any; give -material_beam_damage, or remove "
       "it"},
      {{{"-bc_push_type", "convection"}, {"-bc_push_uy", "-"}, {"-bc_push_value", "300"}},
       ExitCode::usage,
       "-bc_push_h: missing; allowed: an expression; type convection needs it"},
      {{{"-material_wedge_like", "-"},
        {"-material_wedge_E", "1"},
        {"-material_wedge_nu", "0"},
        {"-material_wedge_rho", "1"},
        {"-material_beam_c_v", "880 J/(kg.K)"}},
       ExitCode::usage,
       "-material_wedge_c_v: missing; allowed: a heat capacity > 0; other materials have one, and heat is "
       "solved in "
       "all of them"},
      {{{"-material_beam_c_v", "880 J/kg"}},
       ExitCode::usage,
       "-material_beam_c_v \"880 J/kg\": 'J/kg' has the wrong dimension; allowed: a number in kg/(m.s^2.K), "
       "or one "
       "with a unit of that kind"},
      {pressed({{"-material_beam_E", "72 GPa"}}), ExitCode::usage,
       "-material_beam_E: has no meaning with -material_beam_eos, whose bulk modulus is rho c0^2; give "
       "-material_beam_G alone"},
      {pressed({{"-material_beam_K", "140 GPa"}}), ExitCode::usage,
       "-material_beam_K: has no meaning with -material_beam_eos, whose bulk modulus is rho c0^2; give "
       "-material_beam_G alone"},
      {pressed({{"-material_beam_G", "-"}}), ExitCode::usage,
       "-material_beam_G: missing; the shear modulus is needed beside -material_beam_eos, which tells the "
       "bulk "
       "modulus"},
      {pressed({{"-material_beam_eos_c0", "-"}}), ExitCode::usage,
       "-material_beam_eos_c0: missing; -material_beam_eos mie_grueneisen needs it"},
      {pressed({{"-material_beam_alpha_t", "1e-5"}}), ExitCode::usage,
       "-material_beam_alpha_t: follows from -material_beam_eos_gamma; remove it"},
      {pressed({{"-plane", "stress"}}), ExitCode::usage,
       "-material_beam_eos \"mie_grueneisen\": not available with -plane stress, where nothing is pressed "
       "hard; "
       "allowed: strain, axisymmetric, or meshes in space; choose none"},
      {pressed(damaged({{"-material_beam_split", "spectral"}})), ExitCode::usage,
       "-material_beam_split \"spectral\": not available with -material_beam_eos, whose energy is no sum "
       "over "
       "principal stretches; allowed: -material_beam_eos none; choose volumetric or star_convex"},
      {pressed({{"-material_beam_c_v", "3.4e6"}}), ExitCode::usage,
       "-material_beam_eos_gamma: missing; -material_beam_eos mie_grueneisen needs it with heat"},
      {pressed({{"-material_beam_c_v", "3.4e6"}, {"-material_beam_eos_gamma", "3.1"}}), ExitCode::usage,
       "-material_beam_eos_gamma \"3.1\": is above twice -material_beam_eos_s 1.489, where the energy has no "
       "lower bound; allowed: 0 to 2 s"},
      {pressed({{"-material_beam_c_v", "3.4e9"}, {"-material_beam_eos_gamma", "2"}}), ExitCode::usage,
       "-material_beam_eos_gamma \"2\": Gamma^2 c_v theta0 is more than a third of rho c0^2, and the energy "
       "not "
       "positive; check the units of -material_beam_c_v and -material_beam_eos_c0"},
      {{{"-material_beam_eos_s", "1.5"}},
       ExitCode::usage,
       "-material_beam_eos_s: has no meaning without -material_beam_eos; add -material_beam_eos "
       "mie_grueneisen, "
       "or remove it"},
  };
  return all;
}

TEST(Scenario, MessagesSayWhatWhereAndWhatIsAllowed) {
  for (const auto& [changes, code, message] : rows()) {
    const Outcome result = outcome(with(changes));
    EXPECT_EQ(result.code, code) << message;
    EXPECT_EQ(result.message, message);
  }
}

} // namespace

# labels: run
# timeout: 300
# long: 600
"""What a user asks of PETSc takes effect or is refused: each row is an option of a solver or of the integrator and where its
effect shows: in counts of the history, in its digits, in what is printed, or in one line that refuses it (exit status 2) or
tells that it is without effect. What takes effect leaves the solution where it was, and a run that goes on from a checkpoint
is the same with it. Each fifth row, all in the long form."""
import os
import re
import shlex
import shutil

from _histories import difference
from _runs import SOURCE, check, finish, long, mesh, require, run, some

COUNTS = ("tries", "newton", "linear", "damage_its", "heat_its")
# Contexts, which the rows change: sheared and pressed so far that Newton's method needs some iterations; pulled until phi grows,
# without and with bounds; heated.
BLOCK = {"mesh": mesh("block.geo"), "mesh_set_n": 6, "materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3,
         "bcs": "hold,push", "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_push_on": "top", "bc_push_ux": "0.3*t",
         "bc_push_uy": "(-0.3*t)", "ts_type": "static", "ts_dt": 0.5, "ts_max_time": 0.5, "outputs": "none",
         "output_overwrite": "on"}
run("mesh", {**BLOCK, "mesh_convert": "block.h5"})
BLOCK = {**{key: value for key, value in BLOCK.items() if not key.startswith("mesh")}, "mesh": "block.h5"}
KRYLOV = {**BLOCK, "motion_ksp_type": "gmres", "motion_ksp_rtol": 1e-8}
DAMAGE = {**BLOCK, "material_solid_damage": "at2", "material_solid_Gc": 2e3, "material_solid_gamma": 0.4, "coupling_snes_max_it": 1,
          "bc_push_ux": 0, "bc_push_uy": "0.02*t", "ts_dt": 0.25}
HEAT = {**{key: value for key, value in BLOCK.items() if not key.startswith("bc_push")}, "material_solid_c_v": 1e6,
        "material_solid_conductivity": 5e5, "bcs": "hold,warm", "bc_warm_on": "left", "bc_warm_type": "temperature",
        "bc_warm_value": "300+400*t", "ts_dt": 0.25}
CONTEXTS = {
    "lu": BLOCK,
    "l2": {**BLOCK, "motion_snes_linesearch_type": "l2"},
    "bt": {**BLOCK, "motion_snes_linesearch_type": "bt"},
    "ilu": {**KRYLOV, "motion_pc_type": "ilu"},
    "gamg": {**KRYLOV, "motion_pc_type": "gamg"},
    "hypre": {**KRYLOV, "motion_pc_type": "hypre"},
    "damage": DAMAGE,
    "vi": {**DAMAGE, "material_solid_damage": "at1", "material_solid_Gc": 20, "material_solid_gamma": 0.3,
           "energy_stop": 0, "damage_snes_type": "vinewtonrsls"},
    "heat": HEAT,
}
# Counts change, digits of the solution change, the log says it (what follows "says"), PETSc's way of failing is told and the step
# cut, one line refuses it and names a remedy, one line tells that nothing needs it; or more than counts
# changes, as it is meant to; either of effect and refusal.
ROWS = """
lu counts    -motion_snes_rtol 1e-6
lu counts    -motion_snes_atol 10
lu says DIVERGED_MAX_IT.*cut          -motion_snes_max_it 3
lu says DIVERGED_FUNCTION_COUNT.*cut  -motion_snes_max_funcs 3
lu says DIVERGED_DTOL.*cut            -motion_snes_divergence_tolerance 1e-3
lu refused leave.the.option.out       -motion_snes_type newtontr
lu refused leave.the.option.out       -motion_snes_type qn
lu refused leave.the.option.out       -motion_snes_type ngmres
lu refused pc_type.sor                -motion_ksp_type lsqr -motion_pc_type eisenstat
lu refused pc_type.sor                -motion_ksp_type tsirm -motion_pc_type eisenstat
lu refused allowed.*1                 -motion_pc_type two_level -motion_pc_two_level_nodes 0
lu refused exact.derivative           -motion_snes_mf
lu refused exact.derivative           -motion_snes_mf_operator
lu refused exact.derivative           -motion_snes_fd
lu refused exact.derivative           -motion_snes_test_jacobian
lu refused exact.derivative           -motion_snes_test_jacobian_view
lu refused motion_reuse_tangent       -motion_snes_lag_jacobian 2
lu refused motion_reuse_tangent       -motion_snes_lag_preconditioner 2
lu refused motion_reuse_preconditioner -motion_ksp_reuse_preconditioner
lu refused serve.on.within            -motion_snes_lag_jacobian_persists
lu counts    -motion_reuse_tangent 0
lu refused snes_rtol                  -motion_snes_convergence_test skip
lu refused snes_rtol                  -motion_snes_force_iteration
lu refused range                      -motion_snes_stol 1e-3
lu refused dm_refine                  -motion_snes_grid_sequence 1
lu refused norm.of.each               -motion_snes_norm_schedule NONE
lu refused norm.of.each               -motion_snes_function_type PRECONDITIONED
lu refused preconditioner             -motion_snes_npc_side left
lu refused ts_max_reject              -motion_snes_error_if_not_converged
lu refused ts_max_reject              -motion_ksp_error_if_not_converged
l2 counts    -motion_snes_linesearch_damping 0.5
lu counts    -motion_snes_linesearch_type cp
l2 counts    -motion_snes_linesearch_max_it 2
l2 digits    -motion_snes_linesearch_maxstep 0.5
l2 digits    -motion_snes_linesearch_keeplambda
lu refused norm.of.each               -motion_snes_linesearch_norms 0
lu refused Picard                     -motion_snes_linesearch_precheck_picard
lu refused take.bt                    -motion_snes_linesearch_type ncglinear
lu refused missing                    -motion_snes_linesearch_minlambda
lu idle      -motion_snes_linesearch_order 2
lu idle      -motion_snes_linesearch_rtol 1e-3
bt says DIVERGED_MAX_IT               -motion_snes_linesearch_alpha 0.9
lu says SNES.Function.norm            -motion_snes_monitor
lu says SNES.Function.norm            -motion_snes_monitor_short
lu says Vec.Object                    -motion_snes_monitor_solution
lu says Vec.Object                    -motion_snes_monitor_residual
lu says motion_.solve.converged       -motion_snes_converged_reason
lu says SNES.Object:..motion_         -motion_snes_view
lu says Line.search                   -motion_snes_linesearch_monitor
lu refused monitor_solution           -motion_snes_monitor_solution_update
lu refused grid                       -motion_snes_monitor_fields
lu refused tangents                   -motion_snes_monitor_jacupdate_spectrum
lu refused grid                       -motion_snes_convergence_estimate
lu says KSP.Residual.norm             -motion_ksp_monitor
lu says true.resid.norm               -motion_ksp_monitor_true_residual
lu says Linear.motion_.solve          -motion_ksp_converged_reason
lu says KSP.Object:..motion_          -motion_ksp_view
lu refused grid                       -motion_ksp_monitor_error
lu refused grid                       -motion_ksp_view_diagonal_scale
lu refused ksp_view                   -motion_mat_factor_view
lu idle      -motion_ksp_rtol 1e-3
lu idle      -motion_ksp_atol 1
lu idle      -motion_ksp_max_it 3
lu idle      -motion_ksp_norm_type none
lu idle      -motion_ksp_pc_side left
lu refused preonly                    -motion_ksp_initial_guess_nonzero
lu refused pc_type.jacobi             -motion_ksp_diagonal_scale
lu refused null.space                 -motion_ksp_constant_null_space
lu refused one.at.a.time              -motion_ksp_matsolve_batch_size 2
lu refused take.pipecg                -motion_ksp_type pipelcg
lu refused take.pipecg                -motion_ksp_type pipecg2
lu refused take.cg                    -motion_ksp_type qcg
lu idle      -motion_pc_factor_shift_type NONZERO
lu idle      -motion_pc_factor_zeropivot 1e-3
lu idle      -motion_pc_factor_reuse_ordering
lu digits    -motion_pc_factor_mat_solver_type superlu_dist
lu idle      -motion_pc_factor_mat_ordering_type rcm
lu refused take.nd                    -motion_pc_factor_mat_ordering_type wbm
lu refused pattern                    -motion_pc_factor_in_place
lu refused diagonal                   -motion_pc_factor_nonzeros_along_diagonal
lu says ICNTL.7[^:]*:2                -motion_mat_mumps_icntl_7 2 -motion_ksp_view ::ascii_info_detail
lu says ICNTL.14[^:]*:.55             -motion_mat_mumps_icntl_14 55 -motion_ksp_view ::ascii_info_detail
lu says CNTL.1..*threshold.*0.5       -motion_mat_mumps_cntl_1 0.5 -motion_ksp_view ::ascii_info_detail
lu says Entering.DMUMPS               -motion_mat_mumps_icntl_4 2
lu refused mat_mumps_icntl_25         -motion_mat_mumps_icntl_25 2
lu refused mat_mumps_icntl_15         -motion_mat_mumps_icntl_15 2
ilu counts   -motion_ksp_rtol 1e-3
ilu says DIVERGED_LINEAR_SOLVE        -motion_ksp_max_it 3
ilu counts   -motion_ksp_max_it 8 -motion_snes_max_linear_solve_fail 100
ilu counts   -motion_ksp_atol 1e-10
ilu counts   -motion_ksp_type bcgs
ilu digits   -motion_ksp_type cg
ilu counts   -motion_ksp_norm_type unpreconditioned
ilu refused NATURAL                   -motion_ksp_norm_type natural
ilu counts   -motion_ksp_pc_side right
ilu counts   -motion_ksp_gmres_restart 3
ilu digits   -motion_ksp_gmres_modifiedgramschmidt
ilu counts   -motion_ksp_initial_guess_nonzero
ilu refused initial_guess_nonzero     -motion_ksp_guess_type fischer
ilu counts   -motion_ksp_check_norm_iteration 30
ilu counts   -motion_pc_type jacobi
ilu counts   -motion_pc_type sor -motion_pc_sor_omega 1.3
ilu counts   -motion_pc_type bjacobi -motion_pc_bjacobi_blocks 4 -motion_sub_pc_type lu
ilu counts   -motion_pc_type asm -motion_pc_asm_blocks 4 -motion_pc_asm_overlap 3
ilu counts   -motion_pc_type ml
ilu counts   -motion_pc_factor_levels 2
ilu counts   -motion_pc_factor_mat_ordering_type rcm
ilu says type:.NONZERO|using.*shift   -motion_pc_factor_shift_type NONZERO -motion_ksp_view
ilu counts   -motion_reuse_tangent 0.9
gamg counts  -motion_pc_gamg_threshold 0.5
gamg counts  -motion_pc_gamg_type classical
gamg counts  -motion_pc_gamg_agg_nsmooths 0
gamg digits  -motion_pc_gamg_use_sa_esteig 1
gamg digits  -motion_pc_gamg_coarse_eq_limit 5
gamg counts  -motion_pc_gamg_square_graph 0
gamg counts  -motion_pc_gamg_esteig_ksp_max_it 2
gamg digits  -motion_pc_gamg_esteig_ksp_type cg
gamg counts  -motion_pc_gamg_asm_use_agg
gamg counts  -motion_pc_mg_type additive
gamg counts  -motion_pc_mg_multiplicative_cycles 2
gamg counts  -motion_mg_levels_ksp_type richardson
gamg counts  -motion_mg_levels_ksp_max_it 4
gamg counts  -motion_mg_levels_pc_type sor
gamg counts  -motion_mg_levels_pc_type sor -motion_mg_levels_pc_sor_its 3
gamg digits  -motion_mg_levels_ksp_chebyshev_esteig 0,0.2,0,1.1
gamg counts  -motion_mg_coarse_pc_type jacobi
gamg refused take.pipecg              -motion_mg_levels_ksp_type pipelcg
gamg refused nothing.in.this.run      -motion_mg_fine_pc_type sor
gamg idle    -motion_pc_hypre_type pilut
hypre counts -motion_pc_hypre_type euclid
hypre counts -motion_pc_hypre_boomeramg_max_iter 2
hypre counts -motion_pc_hypre_boomeramg_P_max 1
hypre counts -motion_pc_hypre_boomeramg_agg_nl 1
hypre counts -motion_pc_hypre_boomeramg_relax_type_all Jacobi
hypre counts -motion_pc_hypre_boomeramg_cycle_type W
hypre counts -motion_pc_hypre_boomeramg_nodal_coarsen 1
hypre digits -motion_pc_hypre_boomeramg_interp_type ext+i
hypre refused vec_interp_variant      -motion_pc_hypre_boomeramg_vec_interp_variant 2
damage counts -damage_snes_ksp_ew
damage digits -damage_snes_ksp_ew -damage_snes_ksp_ew_version 3 -damage_snes_ksp_ew_rtol0 0.1
damage digits -damage_ksp_type gmres
damage digits -damage_pc_type jacobi
damage digits -damage_pc_type hypre
damage digits -damage_pc_factor_levels 2
damage digits -damage_ksp_initial_guess_nonzero
damage says DIVERGED_LINEAR_SOLVE     -damage_ksp_max_it 1
damage says damage_.solve.converged   -damage_snes_converged_reason
damage says KSP.Residual.norm         -damage_ksp_monitor
damage refused leave.the.option.out   -damage_snes_type newtonls
damage refused serve.on.within        -damage_snes_lag_preconditioner 3 -damage_snes_lag_preconditioner_persists
damage refused out.of.range|whole     -damage_snes_lag_preconditioner ' -2'
damage refused lag_preconditioner     -damage_ksp_reuse_preconditioner
damage refused take.pipecg            -damage_ksp_type pipelcg
damage either .                       -damage_pc_type gamg
vi counts    -damage_snes_type vinewtonssls
vi counts    -damage_snes_type vinewtonssls -damage_pc_type ilu
vi refused jacobi                     -damage_snes_type vinewtonssls -damage_pc_type icc
vi says DIVERGED_MAX_IT.*cut          -damage_snes_max_it 1
vi changes   -damage_snes_rtol 0.9
vi changes   -damage_snes_atol 0.35
vi counts    -damage_snes_ksp_ew
vi counts    -damage_ksp_rtol 1e-2
vi digits    -damage_snes_linesearch_type l2
heat changes -heat_snes_rtol 1e-4
heat counts  -heat_ksp_rtol 1e-2
heat counts  -heat_snes_ksp_ew
heat counts  -heat_snes_lag_jacobian 2
heat digits  -heat_snes_lag_preconditioner 2
heat digits  -heat_ksp_type gmres
heat digits  -heat_pc_type jacobi
heat digits  -heat_pc_type gamg
heat digits  -heat_ksp_initial_guess_nonzero
heat says DIVERGED_MAX_IT.*cut        -heat_snes_max_it 1
heat says DIVERGED_FUNCTION_COUNT     -heat_snes_max_funcs 2
heat says DIVERGED_LINEAR_SOLVE       -heat_ksp_max_it 1
heat refused leave.the.option.out     -heat_snes_type qn
heat refused serve.on.within          -heat_snes_lag_jacobian_persists
heat says heat_.solve.converged       -heat_snes_converged_reason
heat idle    -heat_ksp_type preonly -heat_pc_type lu -heat_ksp_rtol 1e-3
damage says SNES.Function.norm        -coupling_snes_monitor
damage refused grid                   -coupling_snes_monitor_fields
damage refused coupling_snes_atol     -coupling_snes_rtol 1e-3
damage changes -coupling_snes_max_it 3 -coupling_snes_atol 1e-6
lu says SNES.Function.norm            -uzawa_snes_monitor
lu refused allowed                    -ts_type beuler
lu refused ts_adapt_dphi              -ts_adapt_type basic
lu refused ts_adapt_dphi              -ts_rtol 1e-3
lu refused ts_adapt_dphi              -ts_exact_final_time interpolate
lu says TSAdapt                       -ts_adapt_monitor
lu says TS.dt                         -ts_monitor
lu says max.*min                      -ts_monitor_extreme
lu says TS.Object                     -ts_view
lu says DIVERGED_NONLINEAR_SOLVE      -ts_max_snes_failures 1 -motion_snes_max_it 2
lu refused remove                     -ts_monitor_frequency 2
lu refused remove                     -ts_monitor_error
lu refused remove                     -ts_monitor_envelope
lu refused remove                     -ts_monitor_sp_eig
"""


def words(text):
    """{option: value} of a command line."""
    options, name = {}, None
    for word in shlex.split(text):
        if word.startswith("-"):
            name = word[1:]
            options[name] = ""
        else:
            options[name] = word.strip()
    return options


def changed(context, options):
    """(lines that begin with `impact: `, exit status, whether counts differ, largest difference relative to its column, log)."""
    r = run("row", {**CONTEXTS[context], **options}, code=None, refused=None)
    said = [line for line in r.log.splitlines() if line.startswith("impact: ")] or r.log.splitlines()[-1:]
    a = known[context].history
    alike = r.code == 0 and list(a) == list(r.history) and len(a["time"]) == len(r["time"])
    counts = r.code == 0 and (not alike or any(list(a[c]) != list(r[c]) for c in COUNTS if c in a))
    if alike:
        apart = difference(a, r.history, exact=False)[0]
    else:
        ends = [{name: column[[0, -1]] for name, column in history.items()} for history in (a, r.history)]
        apart = difference(*ends, exact=False)[0] if r.code == 0 else None
    return said, r.code, counts, apart, r.log


known = {name: run("base_" + name, options) for name, options in CONTEXTS.items()}


def judge(context, kind, pattern, text):
    options = words(text)
    said, code, counts, apart, log = changed(context, options)
    if kind == "either":
        kind = "refused" if code == 2 else "digits"
    if kind == "refused":
        good = (code == 2 and "PETSC ERROR" not in log and log.rstrip().endswith(said[-1]) and re.search(pattern, said[-1])
                and any("-" + name in said[-1] for name in options))
    elif kind == "idle":
        good = code == 0 and any("without effect" in line and list(options)[-1] in line for line in said) and apart < 1e-12
    elif kind == "says":
        good = re.search(pattern, log) and not re.search(pattern, known[context].log) and code in (0, 5)
    elif kind in ("counts", "changes"):
        good = code == 0 and counts and (apart < 1e-4 or kind == "changes")
    else:
        good = code == 0 and (counts or apart > 0) and apart < 1e-6
    why = said[-1] if code else f"counts differ: {counts}, solution by {apart:.1e}"
    require(f"{context}: {text}: {kind}" + ("" if good else f", but status {code}, {why}"), good)


for row in ROWS.split("\n")[:: 1 if long() else 9]:
    if row:
        context, kind, rest = row.split(None, 2)
        pattern, text = ("", rest) if rest.startswith("-") else rest.split(None, 1)
        judge(context, kind, pattern, text)

# Forcing terms: refused by name, or they take effect with all their parameters.
with open(f"{SOURCE}/src/scenario/option_names.cpp") as file:
    displaced = '"snes_ksp_ew"' in file.read()
for more in ("", " -motion_snes_ksp_ew_version 3 -motion_snes_ksp_ew_rtol0 0.1"):
    judge("ilu", "refused" if displaced else "counts", "motion_ksp_rtol", "-motion_snes_ksp_ew" + more)

# What serves on from step to step is forgotten at a checkpoint, by the run that goes on too.
for context, text in some((("ilu", "-motion_ksp_initial_guess_nonzero"), ("heat", "-heat_ksp_initial_guess_nonzero"),
                      ("damage", "-damage_ksp_initial_guess_nonzero"), ("ilu", "-motion_snes_linesearch_keeplambda"),
                      ("heat", "-heat_snes_lag_jacobian 2"), ("heat", "-heat_snes_ksp_ew")), 3):
    options = {**CONTEXTS[context], **words(text), "ts_dt": 0.125, "checkpoint_every": 2}
    for folder in ("whole", "resumed"):
        shutil.rmtree(folder, ignore_errors=True)
    whole = run("whole", options, refused=None)
    shutil.copytree("whole", "resumed")
    first = min(file for file in os.listdir("resumed/checkpoints") if file.endswith(".h5"))
    resumed = run("resumed", {**options, "restart": f"resumed/checkpoints/{first}"}, refused=None)
    worst, where = difference(whole.history, resumed.history, exact=True)
    check(f"{context}: {text}: resumed: largest difference, in {where}", worst, 0, 0, relative=False)
finish()

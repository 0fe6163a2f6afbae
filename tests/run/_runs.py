"""Runs the program from a script and compares what it writes with references."""
import contextlib
import fcntl
import math
import os
import re
import subprocess
import sys
import tempfile

import numpy

PROGRAM = os.environ.get("IMPACT_PROGRAM", "impact")
SOURCE = os.environ.get("IMPACT_SOURCE_DIR", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(SOURCE, "tools"))
import histories  # noqa: E402

# One rank without mpirun: no daemon of Open MPI beside each run (0.2 s). The scripts about signals and kills keep it, as
# users have it. All such runs would share a folder of /tmp, and two that make it in the same moment fail: each script has its
# own. Threads of OpenBLAS would add in an order of their own in each run.
_session = tempfile.TemporaryDirectory(prefix="impact-mpi-")
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ, "OMPI_MCA_ess_singleton_isolated": "1",
               "OMPI_MCA_orte_tmpdir_base": _session.name}
_failures = []
_refused = {}  # run that solved its steps -> tries that were refused and solves that were repeated in it


def long():
    """True in the long form of a script, which its head asks for by "# long: <limit in seconds>"."""
    return "IMPACT_LONG" in os.environ


def some(rows, every):
    """All rows in the long form of a script, in the short one each `every`-th of them."""
    return list(rows)[:: 1 if long() else every]


class Run:
    """A finished run: `code`, `log` (all that was printed), `history` (see read_history) and its folder `dir`."""

    def __init__(self, code, log, folder):
        self.code, self.log, self.dir = code, log, folder
        path = os.path.join(folder, "history.csv")
        self.history = read_history(path) if os.path.exists(path) else {}

    def __getitem__(self, column):
        """A column of the history file as an array."""
        return self.history[column]


def read_history(path):
    """Columns of a history file: bare name -> array."""
    return {name: numpy.array(values) for name, values in histories.read(path)[0].items()}


def mesh(name):
    """A file of the meshes folder."""
    return os.path.join(SOURCE, "meshes", name)


def option_file(name):
    """A file of the options folder."""
    return os.path.join(SOURCE, "options", name)


@contextlib.contextmanager
def cores(ranks):
    """Waits for the cores of the machine, which CTest's scripts share (IMPACT_LOCKS, a folder): a run on one rank goes beside
    others, one on several has all cores. Ranks that wait for one that has lost its core take ten times as long."""
    folder = os.environ.get("IMPACT_LOCKS")
    if folder is None:
        yield
        return
    with open(os.path.join(folder, "turn.lock"), "w") as turn, open(os.path.join(folder, "cores.lock"), "w") as all_cores:
        fcntl.flock(turn, fcntl.LOCK_EX)  # nobody overtakes one that waits for all
        fcntl.flock(all_cores, fcntl.LOCK_EX if ranks > 1 else fcntl.LOCK_SH)
        fcntl.flock(turn, fcntl.LOCK_UN)
        yield


def run(name, options, files=(), ranks=1, code=0, refused=0, takes_back=False):
    """Runs the program in the folder `name` with option files and then `options` (dict without the leading dashes, or
    list of words). Any other exit status than `code` (None: any) ends the script. `refused`: tries of steps that may be
    refused because Newton's method failed, and solves repeated another way, in a run that ends well: a number, or None for any. `takes_back`: the law
    lets a crack take back plastic work that had become heat (theory.md, 11), so that the dissipation at a point may be negative."""
    words = []
    for file in files:
        words += ["-options_file", file]
    if isinstance(options, dict):
        for key, value in options.items():
            # PETSc takes a word that begins with a minus for the next option.
            text = str(value)
            words += ["-" + key, " " + text if text.startswith("-") else text]
    else:
        words += list(options)
    command = [PROGRAM] + words + ["-output_dir", name]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks)] + command
    with cores(ranks):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT)
    if code is not None and done.returncode != code:
        print(done.stdout[-4000:])
        print(f"{name}: exit status {done.returncode}, expected {code}\n  {' '.join(command)}")
        sys.exit(1)
    if not takes_back:
        _refuse_negative_dissipation(name, done.stdout)
    finished = Run(done.returncode, done.stdout, name)
    _audit_energy(name, finished)
    if finished.code == 0 and refused is not None:
        _count_refused(finished, refused)
    return finished


def _count_refused(finished, most):
    """A run that silently starts to need more tries has lost something, though its figures may hold. Steps in which damage grew by
    more than -ts_adapt_dphi, or a contact closed by more than -ts_adapt_closing, are cut by their option."""
    repeated = re.search(r"^ *motion solves repeated another way +(\d+)", finished.log, re.M)
    cut = [line for line in finished.log.splitlines() if line.endswith("time step cut") and not re.search("-ts_adapt_(dphi|closing)", line)]
    count = len(cut) + (int(repeated.group(1)) if repeated else 0)
    _refused[finished.dir] = count
    if count > most:
        require(f"{finished.dir}: {count} refused tries and repeated solves, at most {most} expected", False)


def _refuse_negative_dissipation(name, log):
    """The second law in every run of every script: nothing may be dissipated with the wrong sign, at any point in any step."""
    least = smallest_dissipation(log)
    if least < 0:
        require(f"{name}: smallest dissipation at a point {least}, not negative", False)


def smallest_dissipation(log):
    """The last line of the energy sheet: of a step at a point, per volume; 0 without."""
    least = re.search(r"^ *smallest dissipation at a point +(\S+)", log, re.M)
    return float(least.group(1)) if least else 0.0


def _audit_energy(name, run):
    """The energy of every run of every script. `balance` holds to 1e-10; nothing gains energy: not contact by itself, nor the
    column `gain` beyond what shocks, other steps and turning make of what the damped integrator keeps (theory.md, N3: 0 for rho = 1); what
    Newton's method leaves does next to no work. Runs with contact that starts from an overlap are let off: it pushes the bodies apart."""
    if "balance" not in run.history or not len(run["time"]) or not numpy.isfinite(run["balance"]).all():
        return
    def column(*names):  # contact may have come, or gone, at a restart
        return sum((numpy.nan_to_num(run[c]) if c.endswith("_contact") else run[c] for c in names if c in run.history),
                   numpy.zeros(len(run["time"])))
    energy = column("energy_kinetic", "energy_elastic", "energy_plastic", "energy_fracture", "energy_thermal", "energy_contact")
    largest = max(abs(energy).max(), abs(column("work_external")).max(), 1e-300)
    wrong = [("balance", abs(run["balance"]).max(), 1e-10)]
    from_steps = 1e-9
    if "central differences: " in run.log:  # what they keep, -dt^2/8 a.M a, is another one when the length of the steps changes
        square = run["dt"][1:] ** 2
        from_steps += abs(run["energy_numerical"]).max() / largest * abs(numpy.diff(square) / square[:-1]).sum()
    # Turning facets work to third order, augmentations within their tolerance.
    exact = not any(c.endswith("_sliding") for c in run.history) and max(run.history.get("uzawa", [0])) <= 1
    if not any(c.endswith("_gap_min") and run[c][0] < 0 for c in run.history):
        given = -column("dissipated_contact").min() / largest
        gained = run["gain"] + numpy.minimum(run["exchange_numerical"], 0) if "energy_numerical" in run.history else numpy.zeros(1)
        # Explicit contact pushes out what lies deep in a facet at once (theory.md, 78''), and tells what that gives.
        pushes = "central differences: " in run.log and (column("energy_contact").max() > 0 or "came to lie deep in facets" in run.log)
        # What contact may give by itself is not the integrator's.
        wrong += [("energy that contact gave", given, math.inf if pushes else 1e-9 if exact else 1e-7),
                  ("energy that integrator, contact and closing cracks gave",
                   gained.max() / largest, from_steps + given)]
        if "dissipated_contact" not in run.history and "dissipated_closing" not in run.history:
            wrong.append(("energy that the integrator gave", -column("dissipated_numerical").min() / largest, from_steps))
    left = re.search(r"^ *work of unbalanced forces +(\S+)", run.log, re.M)
    if left and abs(energy).max() > 1e-9 * largest:  # else there is nothing but what Newton's method leaves
        wrong.append(("work of unbalanced forces", abs(float(left.group(1))) / largest, 1e-5))
    for claim, value, most in wrong:
        if not value <= most:
            check_between(f"{name}: {claim}, relative", value, -numpy.inf, most)


def check(claim, measured, reference, tolerance, relative=True):
    """Prints a measured number beside its reference; remembers when they differ by more than the tolerance."""
    difference = abs(measured - reference)
    if relative:
        difference /= abs(reference)
    good = bool(difference <= tolerance)
    print(f"{'ok  ' if good else 'FAIL'} {claim}: {measured:.10g}, reference {reference:.10g}, "
          f"{'relative ' if relative else ''}difference {difference:.2e}, tolerance {tolerance:.0e}", flush=True)
    if not good:
        _failures.append(claim)
    return good


def check_between(claim, measured, low, high):
    """Prints a measured number with its interval; remembers when it lies outside."""
    good = bool(low <= measured <= high)
    print(f"{'ok  ' if good else 'FAIL'} {claim}: {measured:.10g}, expected {low:.10g} to {high:.10g}", flush=True)
    if not good:
        _failures.append(claim)
    return good


def require(claim, holds):
    """A yes-or-no claim."""
    print(f"{'ok  ' if holds else 'FAIL'} {claim}", flush=True)
    if not holds:
        _failures.append(claim)
    return bool(holds)


def finish():
    """Ends the script: exit status 1 when a claim failed."""
    if _refused:
        print(f"     refused tries and repeated solves in {len(_refused)} runs:",
              ", ".join(f"{name} {count}" for name, count in _refused.items() if count) or "none")
    if _failures:
        print(f"{len(_failures)} of the claims failed: " + "; ".join(_failures))
        sys.exit(1)
    sys.exit(0)


# Two elastic blocks with non-matching sides: the upper one flies, touches the lower one and slides. At Gauss points, because
# two equal runs on two ranks differ by 1e-10 with the default form, whose multipliers stand at a thousand penalties in the
# matrix, and MUMPS adds in the order of messages.
_BLOCKS = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 6, "mesh_set_n_upper": 5, "mesh_set_gap": 0.017,
    "mesh_set_inset": 0.1,
    "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3, "material_lower_rho": 1000,
    "material_upper_like": "lower",
    "bcs": "hold", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix",
    "ics": "flight", "ic_flight_on": "upper", "ic_flight_vx": 0.3, "ic_flight_vy": -1,
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "contact_face_method": "gpts", "ts_dt": 2e-3, "ts_max_time": 0.06, "ts_newmark_rho": 0.9,
}
# Without augmentations, whose number may hang on the last digits of a multiplier.
TWO_BLOCKS = {**_BLOCKS, "contact_face_enforce": "penalty"}
# With multipliers, and a lower block that flows and breaks: every kind of state there is.
BREAKING_BLOCKS = {
    **_BLOCKS, "material_lower_model": "j2", "material_lower_sigma_y": 3e3, "material_lower_hardening": "linear",
    "material_lower_linear_h": 1e5, "material_lower_damage": "at2", "material_lower_Gc": 50,
    "material_lower_gamma": 0.4, "material_upper_model": "elastic", "material_upper_damage": "none",
    "outputs": "vis", "output_vis_every": 3,
}

"""The runs of all test scripts in three further modes. `python3 tests/run/_modes.py [--modes recover,...]
[--share k/n] [--budget seconds] [--in-turn] [script ...]` takes every run that a script makes and repeats it:

recover      with checkpoints at its half, then again from that checkpoint in a copy of its folder, so that what was
             written after the checkpoint has to be cut off
repartition  the same on other numbers of ranks
restep       with every step tried, refused and tried again with the same dt

The histories have to agree: to 1e-12 of each column's scale on the same ranks, to 1e-8 on others, and where two equal
runs on several ranks, or two whole runs on those numbers of ranks, differ by themselves, to ten times that,
at most 1e-6. Modes other than
recover run with Newton and damage solved to 1e-12 by direct solvers, unless the script says how to solve."""
import argparse
import contextlib
import glob
import io
import math
import os
import re
import runpy
import shutil
import sys
import time

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import _runs  # noqa: E402

TOLERANCE = {"recover": 1e-12, "restep": 1e-12, "repartition": 1e-8}
MOST_NOISE = 1e-6  # what a difference may be at most, however much runs differ by themselves
TIGHT = {"motion": {"motion_snes_rtol": 1e-12, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
                    "motion_pc_factor_mat_solver_type": "mumps"},
         "damage": {"damage_snes_rtol": 1e-12, "damage_ksp_type": "preonly", "damage_pc_type": "cholesky",
                    "damage_pc_factor_mat_solver_type": "mumps"}}
# Work, balances and what the last pass left are no state; the tip of a crack jumps from node to node.
NOT_COMPARED = ("tries", "newton", "newton_most", "linear", "uzawa", "damage_its", "heat_its", "balance", "balance_first_law",
                "coupling_error", "entropy_produced")
RANKS = ((1, 2), (2, 1), (2, 3), (4, 2))
ON_ONE_RANK = re.compile(r"-motion_pc_type icc|solver_type petsc")
plain_run = _runs.run


def family(column):
    """Columns of one kind share a scale: a component that is zero but for the solver's tolerance is measured by its
    vector, and by what else is of its kind: energies, forces, impulses, displacements."""
    if column.startswith(("energy", "work", "dissipated")) or re.match(r"contact_\w+_work$", column):
        return "energy"
    if column.startswith("moment_"):
        return "moment"
    if re.match(r"rigid_\w+_[lruvw][xyz]$", column):
        return {"l": "spin", "r": "rotation", "u": "displacement", "v": "velocity", "w": "turning"}[column[-2]]
    if column.startswith("reaction") or re.match(r"contact_\w+_force", column):
        return "force"
    if column.startswith(("momentum", "impulse")):
        return "momentum"
    if re.match(r"contact_\w+_pressure", column):
        return column.rsplit("_", 1)[0]
    # Gaps that are held closed are rounding of displacements.
    if re.match(r"(mean|probe|measure)_\w+_u[xyz]$|contact_\w+_gap_min$", column):
        return "displacement"
    return re.sub(r"_?[va]?(xx|yy|zz|xy|yz|xz|x|y|z)$", "", column)


def largest_modulus(said):
    """Largest of the moduli that the options give as plain numbers, 0 without any."""
    return max((float(n) for n in re.findall(r"-material_\w+_[EK][ \n]+([0-9.]+(?:e[+-]?\d+)?)(?=\s|$)", said)), default=0)


def rounding(scales, modulus):
    """Below these scales a column is rounding: stresses of strains under 1e-10, and what belongs to them. A body is at
    least as large as it moves while it deforms. An iterative solver leaves 1e-16 of prescribed displacements of zero."""
    moved = scales.get("displacement", 0)
    return {"energy": 1e-10 * modulus * min(moved ** 2, moved ** 3), "force": 1e-10 * modulus * min(moved, moved ** 2),
            "stress": 1e-10 * modulus, "displacement": 1e-15}


def difference(a, b, modulus=0):
    """Largest difference of two histories relative to the scale of each column, and the column. `modulus`: of the
    stiffest material; what is rounding beside it is not compared."""
    if list(a) != list(b):
        return math.inf, "columns"
    if len(a["time"]) != len(b["time"]):
        return math.inf, f"{len(a['time'])} and {len(b['time'])} rows"
    scales = {}
    for column, values in a.items():
        finite = abs(values[numpy.isfinite(values)])
        scales[family(column)] = max(scales.get(family(column), 0), finite.max(initial=0))
    none = rounding(scales, modulus)
    worst, where = 0.0, "time"
    for column, values in a.items():
        if column in NOT_COMPARED or column.startswith("crack"):
            continue
        other, scale = b[column], scales[family(column)]
        if (numpy.isfinite(values) != numpy.isfinite(other)).any():
            return math.inf, column
        good = numpy.isfinite(values)
        gap = abs(values[good] - other[good]).max(initial=0)
        # Forces that balance to rounding say nothing: no body is 1e10 lengths long.
        if family(column) == "force" and scale < 1e-10 * scales.get("energy", 0):
            continue
        # Nor do moments beside forces or work, angular momenta beside momenta or energies, rotations beside ways, their
        # rates beside speeds.
        beside = {"moment": ("force", "energy"), "spin": ("momentum", "energy"), "rotation": ("displacement",),
                  "turning": ("velocity",)}
        if scale < 1e-10 * max((scales.get(kind, 0) for kind in beside.get(family(column), ())), default=0):
            continue
        kind = "stress" if re.search("_(stress|von_mises|pressure)$", family(column)) else family(column)
        if scale < none.get(kind, 0):
            continue
        if scale > 0 and gap / scale > worst:
            worst, where = gap / scale, column
    return worst, where


class Report:
    def __init__(self):
        self.rows, self.failed, self.skipped = [], [], []

    def add(self, mode, what, gap, where, noise=0.0):
        tolerance = min(TOLERANCE[mode] + 10 * noise, max(TOLERANCE[mode], MOST_NOISE))
        good = gap <= tolerance
        self.rows.append((mode, gap, good))
        if not good:
            self.failed.append(f"{mode} of {what}: {gap:.2e} in {where}")
        print(f"{'ok  ' if good else 'FAIL'} {mode}, {what}: largest difference {gap:.2e} in {where}, "
              f"tolerance {tolerance:.0e}", file=sys.__stdout__, flush=True)


class Modes:
    """Stands in for _runs.run while a script runs."""

    def __init__(self, script, modes, report, share, deadline, most, in_turn):
        self.script, self.modes, self.report, self.share, self.deadline = script, modes, report, share, deadline
        self.in_turn = in_turn
        self.most, self.count, self.repeated = most, 0, 0

    def __call__(self, name, options, files=(), ranks=1, code=0):
        if self.repeated >= self.most or time.monotonic() > self.deadline:
            sys.exit(0)  # of the script: its other runs are not wanted
        done = plain_run(name, options, files=files, ranks=ranks, code=code)
        self.count += 1
        if done.code != 0 or self.count % self.share[1] != self.share[0] % self.share[1]:
            return done
        if not isinstance(options, dict):
            options = dict(re.findall(r"-([A-Za-z]\w*)\n([^\n]*)", "\n".join(options)))
        what = f"{self.script}: {name}"
        if any(key in options for key in ("restart", "dry_run", "help", "walltime")):
            return done
        if len(done.history.get("time", ())) < 3:
            self.report.skipped.append(f"{what} (a single step)")
            return done
        said = " ".join(open(file).read() for file in files) + " ".join(f"-{key} {options[key]}" for key in options)
        if "alpha2" in said:
            self.report.skipped.append(f"{what} (alpha2 writes no checkpoints)")
            return done
        self.repeated += 1
        for mode in self.modes:
            self.repeat(mode, what, name, options, files, ranks, done, said)
        return done

    def tight(self, said):
        # A tangent that serves on, or interpolation that does, is a memory that a refused step clears.
        extra = {"motion_reuse_tangent": 0}
        if "gamg" in said:
            extra["motion_pc_gamg_reuse_interpolation"] = 0
        for solver, options in TIGHT.items():
            if f"-{solver}_ksp" not in said and f"-{solver}_pc" not in said and "contact_operator" not in said:
                extra.update(options)
                if solver == "motion" and "-motion_mat_type sbaij" in said:
                    extra["motion_pc_type"] = "cholesky"
        return extra

    def repeat(self, mode, what, name, options, files, ranks, done, said):
        half = max(1, int(done["step"][-1]) // 2)
        base = {**options, "checkpoint_every": half, "checkpoint_keep": 100, "checkpoint_wall": 0}
        pairs = [(ranks, ranks)]
        if mode == "repartition" and ON_ONE_RANK.search(said):
            self.report.skipped.append(f"{what} (its solver works on one rank)")
            return
        if mode != "recover":
            base.update(self.tight(said))
        if mode == "repartition":
            pairs = [RANKS[self.count % len(RANKS)]] if self.in_turn or self.share[1] > 1 or ranks > 1 else list(RANKS)
        for before, after in pairs:
            folder = f"{name}.{mode}{before}{after}"
            label = f"{what}, {before} -> {after} ranks" if mode == "repartition" else what
            reference = plain_run(folder, base, files=files, ranks=before, code=None)
            if reference.code == 0 and int(reference["step"][-1]) < half:
                # Another solver may take fewer steps: its half is another one.
                base["checkpoint_every"] = max(1, int(reference["step"][-1]) // 2)
                shutil.rmtree(folder)
                reference = plain_run(folder, base, files=files, ranks=before, code=None)
            if reference.code != 0:
                self.report.add(mode, label, math.inf, f"nothing: exit status {reference.code}, "
                                + reference.log.strip().splitlines()[-1])
                continue
            if mode == "restep":
                shutil.copytree(folder, folder + "_again")
                refusing = {**base, "test_restep": 1}
                if re.search(r"-ts_max_reject\s+0\b", said):
                    refusing["ts_max_reject"] = 1
                again = plain_run(folder + "_again", refusing, files=files, ranks=before, code=None)
                if again.code != 0:
                    self.report.add(mode, label, math.inf, f"nothing: exit status {again.code}, "
                                    + again.log.strip().splitlines()[-1])
                    continue
                if (again["tries"][1:] < 2).any():
                    self.report.add(mode, label, math.inf, "tries: a step was not repeated")
                    continue
            else:
                shutil.copytree(folder, folder + "_again")
                file = os.path.join(folder + "_again", "checkpoints", "checkpoint_000001.h5")
                again = plain_run(folder + "_again", {**base, "restart": file}, files=files, ranks=after, code=None)
                if again.code != 0:
                    self.report.add(mode, label, math.inf, f"nothing: exit status {again.code}, "
                                    + again.log.strip().splitlines()[-1])
                    continue
                if "resumed from" not in again.log:
                    self.report.add(mode, label, math.inf, "nothing: the run was not resumed")
                    continue
            gap, where = difference(reference.history, again.history, largest_modulus(said))
            for field_file in glob.glob(os.path.join(folder, "*.xdmf")):
                times = [re.findall(r'<Time Value="([^"]*)"', open(path).read())
                         for path in (field_file, os.path.join(folder + "_again", os.path.basename(field_file)))]
                if [float(t) for t in times[0]] != [float(t) for t in times[1]]:
                    close = len(times[0]) == len(times[1]) and all(
                        abs(float(x) - float(y)) <= 1e-12 * abs(float(x)) for x, y in zip(*times))
                    if not close:
                        gap, where = math.inf, "times of " + os.path.basename(field_file)
            noise = 0.0
            if TOLERANCE[mode] < gap < MOST_NOISE and (before > 1 or after > 1):
                # MUMPS on several ranks adds in the order in which messages come: what two equal runs differ by. On
                # other ranks all sums round otherwise, which a slender body shows enlarged by the ratio of its
                # stiffnesses: what whole runs differ by. Some agree to the last bit.
                for _ in range(6):
                    repeat = plain_run(folder + "_repeat", base, files=files, ranks=after)
                    noise = max(noise, difference(reference.history, repeat.history)[0])
                    if gap <= 10 * noise:
                        break
                label += f" ({'equal' if before == after else 'whole'} runs differ by {noise:.1e})"
            self.report.add(mode, label, gap, where, noise)
            shutil.rmtree(folder)
            shutil.rmtree(folder + "_again")


def scripts():
    """All scripts that make runs, but those that are about restarts."""
    found = sorted(glob.glob(os.path.join(HERE, "[!_]*.py")))
    return [path for path in found
            if not os.path.basename(path).startswith(("reliability", "readme", "verify_restart", "bench"))]


def exercise(paths, modes, share=(0, 1), budget=math.inf, most=math.inf, in_turn=False):
    """Runs the scripts with their runs in all `modes`; of each script every share[1]-th run, beginning with number
    share[0], and `most` of them; nothing is begun `budget` seconds after the start. `in_turn`: the pairs of rank
    counts take turns instead of all at each run. Returns the report."""
    report, deadline = Report(), time.monotonic() + budget
    above, argv = os.getcwd(), sys.argv
    for path in paths:
        stem = os.path.splitext(os.path.basename(path))[0]
        if time.monotonic() > deadline:
            report.skipped.append(f"{stem} (no time left)")
            continue
        folder = os.path.join(above, stem)
        os.makedirs(folder, exist_ok=True)
        os.chdir(folder)
        sys.argv = [path]
        _runs.run = Modes(stem, modes, report, share, deadline, most, in_turn)
        _runs._failures.clear()
        said = io.StringIO()  # what the script itself claims belongs to its own test
        try:
            with contextlib.redirect_stdout(said):
                runpy.run_path(path, run_name="__main__")
        except SystemExit as end:
            if end.code:
                print(f"     {stem} itself ended with status {end.code}: {said.getvalue().strip().splitlines()[-1:]}")
        finally:
            _runs.run, sys.argv = plain_run, argv
            os.chdir(above)
    return report


def conclude(report):
    """Prints the sums and ends the script."""
    for mode in TOLERANCE:
        gaps = [(gap, good) for m, gap, good in report.rows if m == mode]
        if gaps:
            print(f"     {mode}: {sum(good for _, good in gaps)} of {len(gaps)} agree, "
                  f"worst {max(gap for gap, _ in gaps):.2e}")
    for what in report.skipped:
        print(f"     not repeated: {what}")
    if report.failed or not (report.rows or report.skipped):
        print(f"{len(report.failed)} failed: " + "; ".join(report.failed))
        sys.exit(1)
    sys.exit(0)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--modes", default=",".join(TOLERANCE))
    parser.add_argument("--share", default="0/1", help="k/n: of each script every n-th run, beginning with number k")
    parser.add_argument("--budget", type=float, default=math.inf, help="seconds after which nothing new is begun")
    parser.add_argument("--in-turn", action="store_true", help="each run is moved from one number of ranks to one other")
    parser.add_argument("scripts", nargs="*")
    given = parser.parse_args()
    paths = [os.path.abspath(p if os.path.isfile(p) else os.path.join(HERE, p + ".py")) for p in given.scripts]
    conclude(exercise(paths or scripts(), given.modes.split(","), tuple(map(int, given.share.split("/"))),
                      given.budget, in_turn=given.in_turn))

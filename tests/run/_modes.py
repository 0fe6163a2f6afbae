"""The runs of all test scripts in three further modes. `python3 tests/run/_modes.py [--modes recover,...]
[--share k/n] [--budget seconds] [--in-turn] [script ...]` takes every run that a script makes and repeats it:

recover      with checkpoints at its half, then again from that checkpoint in a copy of its folder, so that what was
             written after the checkpoint has to be cut off
repartition  the same on other numbers of ranks
restep       with every step tried, refused and tried again with the same dt

Histories and fields have to agree: to 1e-12 of each column's scale on the same ranks, counts too where a single rank forms
all sums in one order, and to 1e-8 on others (_histories.py). To that comes ten times what rounding alone does to such a run,
at most 1e-6: on several ranks, what two equal runs differ by, because MUMPS adds in the order of messages; on other ranks,
what a run on the same ranks differs by whose mesh is larger by a few units in the last place. A script in which nothing was
compared fails, unless its runs are single steps (SINGLE_STEPS). Modes other than recover run with Newton and damage solved to 1e-12 by direct
solvers, unless the script says how to solve. A run that writes no fields writes them here."""
import argparse
import contextlib
import functools
import glob
import io
import math
import os
import re
import runpy
import shutil
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import _runs  # noqa: E402
from _histories import difference, fields_difference, largest_modulus  # noqa: E402

TOLERANCE = {"recover": 1e-12, "restep": 1e-12, "repartition": 1e-8}
MOST_NOISE = 1e-6  # what a difference may be at most, however much runs differ by themselves
TIGHT = {"motion": {"motion_snes_rtol": 1e-12, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
                    "motion_pc_factor_mat_solver_type": "mumps"},
         "damage": {"damage_snes_rtol": 1e-12, "damage_ksp_type": "preonly", "damage_pc_type": "cholesky",
                    "damage_pc_factor_mat_solver_type": "mumps"}}
RANKS = ((1, 2), (2, 1), (2, 3), (4, 2))
ON_ONE_RANK = re.compile(r"-motion_pc_type icc|solver_type petsc")
plain_run = _runs.run


def repeat_run(*arguments, **more):
    """What a repetition needs of tries, and what its law takes back, is no claim here."""
    return plain_run(*arguments, **more, refused=None, takes_back=True)


class Report:
    def __init__(self):
        self.rows, self.failed, self.skipped = [], [], []
        self.compared = {}  # script -> comparisons

    def add(self, mode, what, gap, where, noise=0.0):
        tolerance = min(TOLERANCE[mode] + 10 * noise, max(TOLERANCE[mode], MOST_NOISE))
        good = gap <= tolerance
        stem = what.split(":")[0]
        self.compared[stem] = self.compared.get(stem, 0) + 1
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

    def __call__(self, name, options, files=(), ranks=1, code=0, **more):
        if self.repeated >= self.most or time.monotonic() > self.deadline:
            sys.exit(0)  # of the script: its other runs are not wanted
        done = plain_run(name, options, files=files, ranks=ranks, code=code, **more)
        self.count += 1
        if done.code != 0 or self.count % self.share[1] != self.share[0] % self.share[1]:
            return done
        if not isinstance(options, dict):
            options = dict(re.findall(r"-([A-Za-z]\w*)\n([^\n]*)", "\n".join(options)))
        what = f"{self.script}: {name}"
        if any(key in options for key in ("restart", "dry_run", "help", "walltime")):
            return done
        single = len(done.history.get("time", ())) < 3  # has no half, but may be refused and tried again
        if single and "restep" not in self.modes:
            self.report.skipped.append(f"{what} (a single step)")
            return done
        said = " ".join(open(file).read() for file in files) + " ".join(f"-{key} {options[key]}" for key in options)
        self.repeated += 1
        for mode in ["restep"] if single else self.modes:
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

    @staticmethod
    def compare(a, b, moved, modulus, exact, skip):
        """Largest difference of histories and fields, and where it is."""
        worst = difference(a.history, b.history, modulus, exact, skip)
        outputs = [{os.path.basename(path)[:-5] for path in glob.glob(os.path.join(run.dir, "*.xdmf"))} for run in (a, b)]
        if outputs[0] != outputs[1]:
            return math.inf, f"field outputs {outputs[0] ^ outputs[1]}"
        for name in sorted(outputs[0]):
            worst = max(worst, fields_difference(b.dir, a.dir, name, by_place=moved, modulus=modulus, exact=exact))
        return worst

    @staticmethod
    def shaken(options, said, k):
        """The options with a mesh that is larger by k units in the last place: every sum rounds otherwise."""
        scale = re.findall(r"-mesh_scale\s+(\S+)", said)
        return {**options, "mesh_scale": repr(float(scale[-1] if scale else 1) * (1 + 2 * k * sys.float_info.epsilon))}

    def repeat(self, mode, what, name, options, files, ranks, done, said):
        half = max(1, int(done["step"][-1]) // 2)
        base = {**options, "checkpoint_every": half, "checkpoint_keep": 100, "checkpoint_wall": 0}
        if not re.search(r"-outputs\s", said):
            base.update({"outputs": "modes", "output_modes_every": half})
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
            reference = repeat_run(folder, base, files=files, ranks=before, code=None)
            if reference.code == 0 and int(reference["step"][-1]) < half:
                # Another solver may take fewer steps: its half is another one.
                base["checkpoint_every"] = max(1, int(reference["step"][-1]) // 2)
                shutil.rmtree(folder)
                reference = repeat_run(folder, base, files=files, ranks=before, code=None)
            if reference.code != 0:
                self.report.add(mode, label, math.inf, f"nothing: exit status {reference.code}, "
                                + reference.log.strip().splitlines()[-1])
                continue
            if mode == "restep":
                shutil.copytree(folder, folder + "_again")
                refusing = {**base, "test_restep": 1}
                if re.search(r"-ts_max_reject\s+0\b", said):
                    refusing["ts_max_reject"] = 1
                again = repeat_run(folder + "_again", refusing, files=files, ranks=before, code=None)
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
                again = repeat_run(folder + "_again", {**base, "restart": file}, files=files, ranks=after, code=None)
                if again.code != 0:
                    self.report.add(mode, label, math.inf, f"nothing: exit status {again.code}, "
                                    + again.log.strip().splitlines()[-1])
                    continue
                if "resumed from" not in again.log:
                    self.report.add(mode, label, math.inf, "nothing: the run was not resumed")
                    continue
            # On one rank every sum has its order, and a refused try changes its own count alone.
            compare = functools.partial(self.compare, modulus=largest_modulus(said), exact=before == after == 1,
                                        moved=before != after, skip=("tries",) if mode == "restep" else ())
            gap, where = compare(reference, again)
            noise = 0.0
            if TOLERANCE[mode] < gap < MOST_NOISE and (before > 1 or after > 1):
                for k in range(1, 7):
                    repeat = repeat_run(folder + "_repeat", self.shaken(base, said, k) if before != after else base,
                                       files=files, ranks=before)
                    noise = max(noise, compare(reference, repeat)[0])
                    shutil.rmtree(folder + "_repeat")
                    if gap <= 10 * noise:
                        break
                label += f" (rounding makes {noise:.1e})"
            self.report.add(mode, label, gap, where, noise)
            shutil.rmtree(folder)
            shutil.rmtree(folder + "_again")


def scripts():
    """All scripts that make runs, but those that are about restarts."""
    found = sorted(glob.glob(os.path.join(HERE, "[!_]*.py")))
    return [path for path in found
            if not os.path.basename(path).startswith(("reliability", "readme", "verify_restart", "bench"))]


# Scripts of which nothing need be compared: their runs are single steps, to which recover and repartition do not apply.
SINGLE_STEPS = ("verify_contact_bent", "verify_contact_patch", "verify_contact_punch")


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
        excused = stem in SINGLE_STEPS and "restep" not in modes
        if not report.compared.get(stem) and not excused and share[1] == 1 and time.monotonic() <= deadline:
            report.failed.append(f"{stem}: nothing was compared")
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
    if report.failed or not report.rows:
        print(f"{len(report.failed)} failed, {len(report.rows)} comparisons: " + "; ".join(report.failed))
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

#!/usr/bin/python3
"""Messages, bytes and reductions of a step by part of the program, of the rank that has most, on several numbers of ranks:
the tables of src/scaling.md. PETSc counts them (-log_view) where it or the program sends; what MUMPS and hypre send inside is
not seen, so the motion is solved by GMRES with PETSc's own multigrid.

    tools/measure_messages.py build/release/impact                      (options/beam_wedge_heat.opts on 2, 4, 8, 16 ranks)
    tools/measure_messages.py build/release/impact options/pile.opts --ranks 2 4 --steps 2 --more "-dm_refine 1"
"""
import argparse
import collections
import csv
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parent.parent
# What a part is: events of the program with all that lies inside of them, in the stages of the steps.
PARTS = {
    "residual of the motion": ["MotionResidual"],
    "tangent of the motion": ["MotionTangent", "MotionMatrix"],
    "its linear solver": ["KSPSolve", "PCSetUp"],
    "contact search": ["ContactSearch"],
    "contact": ["ContactForces", "ContactTangent"],
    "law at the points, balances": ["MotionPoints", "MotionForces", "Balances"],
    "damage": ["Damage"],
    "heat": ["Heat"],
    "history": ["History"],
    "field output": ["FieldOutput"],
    "checkpoint": ["CheckpointWrite"],
}
STAGES = {"its linear solver": ["Motion"], "damage": ["Damage"], "heat": ["Heat"]}  # of a part; else all but the set-up
WRITERS = ("field output", "checkpoint")  # for each time that they write, not for each step


def counts(table):
    """{part: (calls, messages, bytes, reductions)} of the busiest rank. PETSc counts a message where it leaves and where it
    comes in."""
    sums = {part: collections.defaultdict(lambda: [0, 0.0, 0.0, 0.0]) for part in [*PARTS, "whole set-up"]}
    with open(table) as file:
        for row in csv.DictReader(file):
            stage, event, rank = row["Stage Name"], row["Event Name"], row["Rank"]
            for part in sums:
                if part == "whole set-up":
                    counted = stage == "Set-up" and event == "summary"
                elif PARTS[part] == [stage]:
                    counted = event == "summary"
                else:
                    counted = event in PARTS[part] and (stage in STAGES[part] if part in STAGES else stage != "Set-up")
                if counted:
                    values = sums[part][rank]
                    values[0] += int(float(row["Count"] or 0)) if event != "summary" else 0
                    for k, (column, share) in enumerate((("Num Messages", 0.5), ("Message Length", 0.5), ("Num Reductions", 1)), 1):
                        values[k] += share * float(row[column] or 0)
    return {part: tuple(max(value[k] for value in ranks.values()) for k in range(4)) for part, ranks in sums.items() if ranks}


def run(program, options, ranks, steps, more):
    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(folder, "log.csv")
        command = ["mpirun", "-n", str(ranks), program, "-options_file", options, "-ts_max_steps", steps, "-checkpoint_every", steps,
                   "-checkpoint_wall", 0, "-motion_ksp_type", "gmres", "-motion_pc_type", "gamg", "-output_dir", folder,
                   "-log_view", f":{table}:ascii_csv", *more]
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return counts(table)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("options", nargs="?", default=SOURCE / "options" / "beam_wedge_heat.opts")
    parser.add_argument("--ranks", type=int, nargs="+", default=[2, 4, 8, 16])
    parser.add_argument("--steps", type=int, default=4)
    parser.add_argument("--more", default="", help="further options of the program")
    asked = parser.parse_intermixed_args()
    found = {ranks: run(pathlib.Path(asked.program).resolve(), asked.options, ranks, asked.steps, shlex.split(asked.more))
             for ranks in asked.ranks}
    print("| part | " + " | ".join(f"{ranks} ranks" for ranks in asked.ranks) + " |")
    print("|---" * (1 + len(asked.ranks)) + "|")
    for part in [*PARTS, "whole set-up"]:
        cells = []
        for ranks in asked.ranks:
            calls, messages, length, reductions = found[ranks].get(part, (0, 0, 0, 0))
            times = 1 if part == "whole set-up" else max(calls, 1) if part in WRITERS else asked.steps
            cells.append(f"{messages / times:.0f}, {length / times / 1e3:.1f}, {reductions / times:.0f}")
        print(f"| {part} | " + " | ".join(cells) + " |")


main()

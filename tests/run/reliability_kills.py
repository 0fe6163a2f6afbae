# labels: run
# processors: 2
# timeout: 120
# long: 1800
"""R1: kill -9 at any instant, then -restart auto with the same command, gives the uninterrupted result. Half of the kills
come by the clock, half at a write to a checkpoint, to the field output or to the history. `reliability_kills_long` makes
200 of them on three problems and 1 and 2 ranks; `reliability_kills_fields` kills at every write of a field output."""
import os
import random
import re
import shutil

from _reliability import (BOTH, CONTACT, FAULTY, FRACTURE, field_times, fields_difference, fields_fault, finish_within,
                          kill, log_of, largest_difference, rows, start, wait_for, with_mesh)
from _runs import check, finish, long, require

WANTED = int(os.environ.get("IMPACT_COUNT", 200 if long() else 6))
seed = int(os.environ.get("IMPACT_SEED", random.randrange(10**6)))
random.seed(seed)
print(f"     IMPACT_SEED={seed}")

PROBLEMS = {"contact": CONTACT, "fracture": FRACTURE, "both": BOTH}
CASES = [(name, ranks) for ranks in (1, 2) for name in PROBLEMS] if long() else [("both", 1), ("both", 2)]
INTERVAL = 5
FILES = {"checkpoint_": 900, "vis.": 95, "history.csv": 20}  # about as many write calls as a run makes

duration = {}
for name, ranks in CASES:
    folder = f"{name}_{ranks}"
    run = start(folder, with_mesh(PROBLEMS[name]), ranks)
    begun = os.times().elapsed
    require(f"{folder}: the uninterrupted run ends", finish_within(run, 60) == 0)
    duration[name, ranks] = os.times().elapsed - begun

kills = lives = lost_most = silent = 0
worst, where, broken = 0.0, "", []
worst_field, where_field = 0.0, ""
while kills < WANTED:
    name, ranks = CASES[lives % len(CASES)]
    lives += 1
    folder, options = f"life_{lives}", {**with_mesh(PROBLEMS[name]), "restart": "auto"}
    deaths, most = 0, min(WANTED - kills, random.randint(2, 6))
    written = 0
    while True:
        file, by_clock = random.choice(list(FILES)), random.random() < 0.5
        last = deaths == most
        fault = None if by_clock or last else f"kill:{random.randint(1, FILES[file])}:{file}"
        run = start(folder, options, ranks, FAULTY, fault)
        if last:
            code = finish_within(run, 60)
        else:
            if fault is None:
                wait_for(folder, lambda: run.poll() is not None,
                         random.uniform(0.1, 1) * duration[name, ranks])
            else:
                finish_within(run, 30)
            code = run.poll()
            if code is None:
                kill(run)
        resumed = re.search(r"resumed from \S+ at t = \S+, step (\d+)", log_of(folder))
        begun_at = int(resumed.group(1)) if resumed else 0
        if written > 0 and (resumed or "the run starts at t = 0" in log_of(folder)):
            # Row 0 is the start; the row of the step is there before its checkpoint is.
            lost_most = max(lost_most, written - 1 - begun_at)
        if written > INTERVAL + 1 and not resumed and "the run starts at t = 0" not in log_of(folder) and code == 0:
            silent += 1
        if code == 0:
            break
        if last or (fault is None and code is not None and code > 0 and code < 128):
            broken.append(f"{folder} ended with {code}: {log_of(folder).strip().splitlines()[-1:]}")
            break
        deaths += 1
        written = max(rows(folder), begun_at + 1)
    kills += deaths
    gap, column = largest_difference(folder, f"{name}_{ranks}", ranks)
    if gap >= worst:
        worst, where = gap, f"{column} of {folder} ({name}, {ranks} ranks)"
    fault = fields_fault(folder)
    if fault or field_times(folder) != field_times(f"{name}_{ranks}"):
        broken.append(f"{folder}, field output: {fault or 'other times than without kills'}")
        continue
    field_gap, field = fields_difference(folder, f"{name}_{ranks}")
    if field_gap >= worst_field:
        worst_field, where_field = field_gap, f"{field} of {folder} ({name}, {ranks} ranks)"
    if max(gap, field_gap) <= 1e-12:
        shutil.rmtree(folder)
print(f"     {kills} kills in {lives} runs")
for line in broken:
    print("     " + line)
check("runs that did not come to their end or have damaged field output", len(broken), 0, 0, relative=False)
check(f"largest difference from the uninterrupted run, in {where}", worst, 0, 1e-12, relative=False)
check(f"largest difference of a field from the uninterrupted run, {where_field}", worst_field, 0, 1e-12, relative=False)
check("starts from t = 0 without a word", silent, 0, 0, relative=False)
require(f"at most one checkpoint interval of work was lost: {lost_most} of {INTERVAL} steps", lost_most <= INTERVAL)
finish()

# labels: run
# processors: 2
# timeout: 240
# long: 3600
"""How runs end and are gone on with, attacked: a signal of any kind at any moment, on one rank and two, and `-restart auto`
then gives the undisturbed result; folders of half and finished runs in every state and with every other end are gone on
with, refused with one line, or set aside. IMPACT_SEED and IMPACT_COUNT choose the attacks; `reliability_ends_long` takes 300."""
import contextlib
import os
import random
import shutil
import signal
import subprocess
import time

from _reliability import (BOTH, command, crashed, family_of, finish_within, kill, largest_difference, log_of, ranks_of, rows,
                          run_within, start, wait_for, with_mesh)
from _runs import check, finish, long, require

COUNT = int(os.environ.get("IMPACT_COUNT", 150 if long() else 3))  # of each family
seed = int(os.environ.get("IMPACT_SEED", random.randrange(10**6)))
random.seed(seed)
print(f"     IMPACT_SEED={seed}")

STEPS, HALF = 20, 12
OPTIONS = {key: value for key, value in with_mesh(BOTH).items() if not key.startswith("output")}
OPTIONS = {**OPTIONS, "ts_max_time": 1, "ts_max_steps": STEPS, "checkpoint_every": 0}
faults = []


def said(folder):
    return [line for line in log_of(folder).splitlines() if line.startswith("impact: ")]


def run(folder, ranks=1, **more):
    options = {key: value for key, value in {**OPTIONS, **more}.items() if value is not None}
    return run_within(60, folder, options, ranks)


def judge(attack, holds):
    if not holds:
        faults.append(attack)
        print(f"     FAULT {attack}")


def difference(folder, whole):
    try:
        return largest_difference(folder, whole)[0]
    except Exception as error:  # other steps, no file
        return repr(error)


for ranks in (1, 2):
    require(f"undisturbed run on {ranks}", run(f"whole_{ranks}", ranks) == 0)
require("the limit of steps stops a run, and names its checkpoint",
        f"stopped by -ts_max_steps {STEPS}; the state is in" in log_of("whole_1") and "stopped at t" in log_of("whole_1"))
require("half a run", run("half", ts_max_steps=HALF) == 0)

# Signals: what announces an end makes a checkpoint and the end; SIGUSR1 makes a checkpoint.
ENDING = ("SIGINT", "SIGHUP", "SIGXCPU", "SIGTERM", "SIGUSR2")
for i in range(COUNT):
    name = (*ENDING, "SIGUSR1")[i % 6] if long() and i < 6 else random.choice((*ENDING, "SIGUSR1"))
    ranks, late = random.choice((1, 1, 1, 2)), random.random() * 0.5
    folder, attack = "signal", f"{name} to one of {ranks} after {late:.2f} s"
    shutil.rmtree(folder, ignore_errors=True)
    process = start(folder, OPTIONS, ranks)
    wait_for(folder, lambda: log_of(folder) or process.poll() is not None)
    time.sleep(late)
    pids = ranks_of(process) if process.poll() is None else []  # none any more where it has just ended
    for pid in random.sample(pids, min(1, len(pids))):
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, getattr(signal, name))
    code = finish_within(process, 60)
    log = log_of(folder)
    ended = f"stopped by request ({name})" in log
    too_late = "stopped by -ts_max_steps" in log  # all is said and saved, and MPI is ending: the signal changes nothing
    judge(f"{attack}: status {code}, {log.splitlines()[-1:]}", code == 0 and (ended or too_late)
          and not (ended and name == "SIGUSR1") and any(f.endswith(".manifest") for f in os.listdir(folder + "/checkpoints")))
    code = run(folder, ranks, restart="auto")
    gap = difference(folder, f"whole_{ranks}")
    judge(f"{attack}, gone on with: status {code}, difference {gap}", code == 0 and isinstance(gap, float) and gap <= 1e-12)

for ranks in (1, 2):
    process = start("late", OPTIONS, ranks)
    wait_for("late", lambda: "stopped by -ts_max_steps" in log_of("late"))
    with contextlib.suppress(ProcessLookupError, IndexError):
        os.kill(ranks_of(process)[0], signal.SIGTERM)
    require(f"SIGTERM to one of {ranks} behind the last line changes nothing", finish_within(process, 60) == 0)


def newest(folder):
    return sorted(f for f in os.listdir(folder + "/checkpoints") if f.endswith(".h5"))[-1]


def hurt(folder, size):
    with open(f"{folder}/checkpoints/{newest(folder)}", "r+b") as file:
        file.truncate(size)


def write(path, text):
    with open(path, "w") as file:
        file.write(text)


# What is done to a copy of the folder of half a run; options; statuses; words of the messages; steps in the history after it.
AUTO = {"restart": "auto"}
STATES = [
    ("nothing", lambda f: None, AUTO, 0, "resumed from", STEPS),
    ("nothing", lambda f: None, {**AUTO, "ts_max_steps": HALF}, 0, f"stopped by -ts_max_steps {HALF}", HALF),
    ("nothing", lambda f: None, {**AUTO, "ts_max_steps": HALF - 1}, 2, f"-ts_max_steps {HALF - 1}: checkpoint", HALF),
    ("nothing", lambda f: None, {**AUTO, "ts_max_time": 0.01}, 2, "give an end behind it", HALF),
    ("nothing", lambda f: None, {"restart": "half/checkpoints/none.h5"}, 4, "there is no such file", HALF),
    ("nothing", lambda f: None, {"restart": "half"}, 4, "cannot use checkpoint half", HALF),
    ("nothing", lambda f: None, {}, 0, "is now in", STEPS),
    ("nothing", lambda f: None, {"output_overwrite": "on"}, 0, "no longer count", STEPS),
    ("nothing", lambda f: None, {"probes": "a", "probe_a_at": "9,9"}, 3, "the point is in no cell", HALF),
    ("the checkpoint cut", lambda f: hurt(f, 1000), AUTO, 4, "no usable checkpoint", HALF),
    ("no checkpoints", lambda f: shutil.rmtree(f + "/checkpoints"), AUTO, 0, "the run starts at t = 0", STEPS),
    ("no history", lambda f: os.remove(f + "/history.csv"), AUTO, 0, "the rows between are missing", STEPS - HALF - 1),
    ("another history", lambda f: write(f + "/history.csv", "a,b\n1,2\n"), AUTO, 4, "it is no history of this program", 0),
    ("a lock that was left", lambda f: write(f + "/.impact.lock", "process 1 on vm"), AUTO, 0, "resumed from", STEPS),
]
for i in range(max(COUNT, len(STATES))):
    state, change, more, status, words, steps = STATES[i] if i < len(STATES) else random.choice(STATES)
    ranks = 1 if i < len(STATES) else random.choice((1, 1, 2))
    folder, attack = "state", f"{state}, {more} on {ranks}"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree("half", folder)
    change(folder)
    code = run(folder, ranks, **more)
    judge(f"{attack}: status {code}, {log_of(folder).splitlines()[-1:]}, {rows(folder) - 1} steps",
          code == status and words in log_of(folder) and not crashed(code) and "PETSC ERROR" not in log_of(folder)
          and rows(folder) - 1 == steps and (code == 0 or len(said(folder)) <= 3))
    if words == "is now in":
        judge(f"{attack}: what was there is whole", difference(folder + "/earlier_1", "half") == 0
              and os.path.isdir(folder + "/earlier_1/checkpoints") and difference(folder, "whole_1") == 0)
    if (state, more) == ("nothing", AUTO) and ranks == 1:
        judge(f"{attack}: to the same bits", difference(folder, "whole_1") <= 1e-12)

# Two runs in one folder: the second one is refused, and a kill leaves nothing that stops the third.
process = start("twice", {**OPTIONS, "ts_dt": 1e-5, "ts_max_steps": 100000})
wait_for("twice", lambda: rows("twice") > 2)
second = subprocess.run(command("twice", OPTIONS), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
require(f"two in one folder: status {second.returncode}, {second.stdout.splitlines()[-1:]}", second.returncode == 4
        and f'-output_dir "twice": another run writes there (process {process.pid} on ' in second.stdout)
kill(process)
require("after a kill of the first one the folder is free", os.path.exists("twice/.impact.lock") and run("twice") == 0
        and "is now in twice/earlier_1" in log_of("twice") and not os.path.exists("twice/.impact.lock"))

# gmsh works on while it is asked to end; so does a program that nohup protects from SIGHUP.
write("endless.geo", "Point(1) = {0, 0, 0};\nFor i In {1:1e12}\n  x = i;\nEndFor\n")
for name, more in (("SIGINT", {}), ("SIGHUP", {}), ("-walltime", {"walltime": "0:02", "walltime_margin": 1})):
    process = start("gmsh", {**OPTIONS, "mesh": os.path.abspath("endless.geo"), **more})
    begun = time.monotonic()
    wait_for("gmsh", lambda: len(family_of(process.pid)) > 1)
    if name.startswith("SIG"):
        os.kill(process.pid, getattr(signal, name))
    code = finish_within(process, 20)
    require(f"{name} while gmsh works: status {code} after {time.monotonic() - begun:.1f} s, {said('gmsh')[-1:]}", code == 4
            and said("gmsh")[-1].endswith(f"gmsh was ended by {name}; nothing is computed yet, and there is nothing to go on from"))
before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
process = start("nohup", OPTIONS)
signal.signal(signal.SIGHUP, before)
wait_for("nohup", lambda: rows("nohup") > 1)
os.kill(process.pid, signal.SIGHUP)
require("a run below nohup goes on to its end", finish_within(process, 60) == 0 and rows("nohup") == STEPS + 1)

check("signals and states that end otherwise than they should", len(faults), 0, 0, relative=False)
finish()

# labels: run
# timeout: 120
# long: 3600
"""R9: a full disk, a quota, a folder that cannot be written. The checkpoint before stays whole and is what the next run
goes on from; field output is given up with a message while the run goes on; everything else ends with exit status 4 and
one line. A full disk is a write that fails (impact_faulty), a limit on the size of files, and a small tmpfs where the
test may mount one."""
import os
import random
import resource
import shutil
import subprocess

from _reliability import (BOTH, FAULTY, crashed, field_times, fields_fault, finish_within, largest_difference, log_of,
                          ranks_of, rows, run_within, start, wait_for, with_mesh)
from _runs import check, finish, long, require

OPTIONS = {**with_mesh(BOTH), "restart": "auto", "checkpoint_patience": 3}
require("undisturbed run", run_within(60, "whole", OPTIONS) == 0)
if long():
    require("undisturbed run on 2 ranks", run_within(60, "whole_2", OPTIONS, 2) == 0)
size = os.path.getsize("whole/checkpoints/checkpoint_000006.h5")
print(f"     a checkpoint has {size} bytes")


def says(folder, code, path):
    said = [line for line in log_of(folder).splitlines() if line.startswith("impact: ")]
    return (code == 4 and bool(said) and path in said[-1] and "PETSC ERROR" not in log_of(folder)
            and ("No space" in said[-1] or "too large" in said[-1] or "denied" in said[-1] or "Not a directory" in said[-1]
                 or "Read-only" in said[-1] or "cannot" in said[-1]))


def goes_on(folder, whole, ranks=1):
    code = run_within(60, folder, OPTIONS, ranks)
    require(f"{folder}: with space again the same command ends (status {code})", code == 0)
    gap, column = largest_difference(folder, whole)
    check(f"{folder}: largest difference from the undisturbed run, in {column}", gap, 0, 1e-12, relative=False)


# Checkpoints: the k-th change of a checkpoint file fails, and all after it.
for name, first, ranks in (("at_first", 1, 1), ("in_second", 100, 1), ("in_third", 150, 2))[: 3 if long() else 1]:
    folder = "full_" + name
    code = run_within(60, folder, OPTIONS, ranks, FAULTY, f"full:{first}:checkpoint_")
    require(f"{folder}: status 4 (is {code}) and a line that names the file", says(folder, code, "checkpoint_"))
    goes_on(folder, "whole_2" if ranks == 2 else "whole", ranks)

# Each call of the first checkpoint may be the one that fails.
ONE_STEP = {**{key: value for key, value in OPTIONS.items() if not key.startswith("output")}, "ts_max_steps": 1,
            "checkpoint_every": 1, "restart": "none"}
seed = int(os.environ.get("IMPACT_SEED", random.randrange(10**6)))
random.seed(seed)
print(f"     IMPACT_SEED={seed}")
for ranks in (1, 2):
    calls = range(1, 500) if long() else [2] + random.sample(range(3, 60), 3 if ranks == 1 else 1)
    tried, wrong, code = 0, [], None
    for call in calls:
        shutil.rmtree("first", ignore_errors=True)
        code = run_within(30, "first", ONE_STEP, ranks, FAULTY, f"full:{call}:checkpoint_")
        if code == 0:
            break
        tried += 1
        left = os.listdir("first/checkpoints")
        if not says("first", code, "checkpoint_") or "patience" in log_of("first") or \
                any(name.endswith(".manifest") for name in left):
            wrong.append(f"call {call}: status {code}, {log_of('first').splitlines()[-1:]}, left {left}")
    for line in wrong:
        print("     " + line)
    check(f"{ranks} rank(s): full disk at {tried} calls of the first checkpoint, ends without status 4 and a line",
          len(wrong), 0, 0, relative=False)
    if long():
        # 75 calls on one rank; on two a rank makes some 65.
        require(f"{ranks} rank(s): the calls went through the whole checkpoint", code == 0 and call > 50)

# A quota below the size of a checkpoint, and of the field output alone.
run = start("quota", {**OPTIONS, "checkpoint_every": 15})
wait_for("quota", lambda: rows("quota") > 1 or run.poll() is not None)
for pid in ranks_of(run):  # not from the start, because MPI makes files of its own
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (size // 2, size // 2))
code = finish_within(run, 60)
require(f"quota: status 4 (is {code}), no signal", says("quota", code, "checkpoint_") and not crashed(code))
goes_on("quota", "whole")

code = run_within(60, "fields", OPTIONS, 1, FAULTY, "full:60:vis.")
log = log_of("fields")
require(f"field output on a full disk: the run goes on to its end (status {code})",
        code == 0 and "goes on without this output" in log and rows("fields") == rows("whole"))
require(f"field output on a full disk: what was written stays readable {fields_fault('fields')}",
        not fields_fault("fields") and 0 < len(field_times("fields")) < len(field_times("whole")))

code = run_within(60, "history", OPTIONS, 1, FAULTY, "full:20:history.csv")
require(f"history on a full disk: status 4 (is {code}) and a line", says("history", code, "history.csv"))
goes_on("history", "whole")

# No folder at all.
open("a_file", "w").close()
code = run_within(20, "nowhere", {**OPTIONS, "checkpoint_dir": "a_file/x"})
require(f"checkpoint folder below a file: status 4 (is {code})", says("nowhere", code, "a_file"))
if os.geteuid() != 0:
    os.makedirs("locked")
    os.chmod("locked", 0o500)
    code = run_within(20, "locked", {**OPTIONS, "checkpoint_dir": "locked/x"})
    require(f"read-only folder: status 4 (is {code})", says("locked", code, "locked"))
    os.chmod("locked", 0o700)
else:
    print("     read-only folder: not tried, because nothing is read-only for root; /proc takes its place")
    code = run_within(20, "proc", {**OPTIONS, "checkpoint_dir": "/proc/impact"})
    require(f"a folder that the system refuses: status 4 (is {code})", says("proc", code, "/proc/impact"))

os.makedirs("small", exist_ok=True)
mounted = os.geteuid() == 0 and subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={8 * size}", "none", "small"],
                                               stderr=subprocess.DEVNULL).returncode == 0
if mounted:
    try:
        code = run_within(60, "tmpfs", {**OPTIONS, "checkpoint_dir": "small/checkpoints", "checkpoint_every": 2,
                                 "checkpoint_keep": 99})
        require(f"full tmpfs: status 4 (is {code})", says("tmpfs", code, "checkpoint_"))
        done = start("tmpfs", {**OPTIONS, "checkpoint_dir": "small/checkpoints", "checkpoint_every": 0})
        require("full tmpfs: the run goes on from what was written before", finish_within(done, 60) == 0
                and "resumed from small" in log_of("tmpfs"))
    finally:
        subprocess.run(["umount", "small"], check=True)
else:
    print("     tmpfs: not mounted, no right to")
finish()

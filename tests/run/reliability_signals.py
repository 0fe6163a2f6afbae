# labels: run
# processors: 2
# timeout: 120
"""R15: signals and the wall time. SIGUSR1 writes a checkpoint, SIGUSR2 and SIGTERM write one and end the run with exit
status 0 and `stopped by request`, to one rank or to mpirun; -walltime ends it in time. The same command line then goes on
to the result of the undisturbed run. Output into a closed pipe does not end a run."""
import os
import signal
import subprocess
import time

from _reliability import (BOTH, command, field_times, fields_fault, finish_within, largest_difference, log_of, ranks_of, rows,
                          run_within, start, wait_for, with_mesh)
from _runs import check, check_between, finish, require

OPTIONS = {**with_mesh(BOTH), "checkpoint_every": 0, "restart": "auto"}
LONG = {**OPTIONS, "ts_dt": 2e-5}  # a hundred times the steps
reference = {}


def checkpoints(folder):
    try:
        return sorted(name for name in os.listdir(os.path.join(folder, "checkpoints")) if name.endswith(".manifest"))
    except OSError:
        return []


def resumed_equals(folder, options, ranks, whole):
    """The same command again, to the end."""
    code = run_within(60, folder, options, ranks)
    require(f"{folder}: the same command goes on and ends", code == 0 and "resumed from" in log_of(folder))
    gap, column = largest_difference(folder, whole)
    check(f"{folder}: largest difference from the undisturbed run, in {column}", gap, 0, 1e-12, relative=False)
    require(f"{folder}: field output is whole {fields_fault(folder)}",
            not fields_fault(folder) and field_times(folder) == field_times(whole))


for ranks in (1, 2):
    require(f"undisturbed run on {ranks}", run_within(60, f"whole_{ranks}", OPTIONS, ranks) == 0)

for name, number, ranks, to_mpirun in (("usr2", signal.SIGUSR2, 2, False), ("term", signal.SIGTERM, 1, False),
                                       ("usr2_mpirun", signal.SIGUSR2, 2, True)):
    run = start(name, OPTIONS, ranks)
    wait_for(name, lambda: rows(name) > 4 or run.poll() is not None)
    targets = [run.pid] if to_mpirun else ranks_of(run)[-1:]
    sent = time.monotonic()
    for pid in targets:
        os.kill(pid, number)
    code = finish_within(run, 20)
    took = time.monotonic() - sent
    log = log_of(name)
    require(f"{name}: exit status 0 (is {code}) with a line that says so", code == 0 and "stopped by request (SIG" in log)
    require(f"{name}: before the end of the run, with a checkpoint", rows(name) < 30 and len(checkpoints(name)) == 1)
    print(f"     {name}: ended {took:.2f} s after the signal")
    resumed_equals(name, OPTIONS, ranks, f"whole_{ranks}")

run = start("usr1", OPTIONS)
wait_for("usr1", lambda: rows("usr1") > 4 or run.poll() is not None)
for pid in ranks_of(run)[:1]:
    os.kill(pid, signal.SIGUSR1)
require("usr1: a checkpoint during the run", wait_for("usr1", lambda: len(checkpoints("usr1")) == 1 or run.poll() is not None)
        and run.poll() is None or len(checkpoints("usr1")) == 1)
require("usr1: the run goes on to its end", finish_within(run, 60) == 0 and "finished at" in log_of("usr1"))

# By the clock: the margin covers the start and the end of the process.
begun = time.monotonic()
code = run_within(20, "wall", {**LONG, "walltime": "0:03", "walltime_margin": 1})
took = time.monotonic() - begun
require(f"walltime: exit status 0 (is {code}), stopped by request",
        code == 0 and "stopped by request (-walltime)" in log_of("wall"))
check_between("walltime 3 s: seconds that the run took", took, 1, 3)
require("walltime: a checkpoint", len(checkpoints("wall")) == 1)

# A reader that closes the pipe.
words = command("pipe", {key: value for key, value in OPTIONS.items() if key != "restart"})
with open("pipe.log", "w") as log:
    run = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=log)
run.stdout.readline()
run.stdout.close()
code = finish_within(run, 60)
require(f"a closed pipe behind the output: exit status {code}, all rows", code == 0 and rows("pipe") == rows("whole_1"))
finish()

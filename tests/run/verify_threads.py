"""The program holds itself to one thread for each rank where nobody has chosen: the plain command in a plain shell takes
what it takes with the variables of the libraries. Not bound to cores, as with more ranks than cores or under a queue, a
factorisation by SuperLU_DIST otherwise starts a thread for each core in each rank, and they spin."""
# labels: run
# timeout: 150
# processors: 2
import os
import resource
import subprocess
import time

from _runs import ENVIRONMENT, PROGRAM, SOURCE, check_between, finish, require

CHOSEN = ("OMP_", "OPENBLAS_", "GOTO_", "OMPI_MCA_mpi_yield_when_idle")
PLAIN = {name: value for name, value in ENVIRONMENT.items() if not name.startswith(CHOSEN)}
LIMIT = 60  # seconds


def beam_wedge(name, environment):
    """The gallery's first steps on two ranks: whether they ended, most threads of a rank, CPU seconds, what was printed."""
    command = ["mpirun", "--bind-to", "none", "-n", "2", PROGRAM, "-options_file", "options/beam_wedge.opts",
               "-ts_max_time", "0.004", "-output_dir", os.path.abspath(name)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(name + ".log", "w+") as log:
        child = subprocess.Popen(command, cwd=SOURCE, env=environment, stdout=log, stderr=subprocess.STDOUT)
        threads, start = 0, time.monotonic()
        while child.poll() is None:
            for rank in ranks_of(child.pid):
                threads = max(threads, tasks(rank))
            if time.monotonic() - start > LIMIT:
                child.terminate()  # mpirun ends its ranks
                child.wait()
            time.sleep(0.05)
        log.seek(0)
        text = log.read()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return child.returncode == 0, threads, seconds, text


def ranks_of(launcher):
    """Processes of the program below mpirun."""
    try:
        with open(f"/proc/{launcher}/task/{launcher}/children") as file:
            return [int(pid) for pid in file.read().split()]
    except OSError:
        return []


def tasks(pid):
    try:
        return len(os.listdir(f"/proc/{pid}/task"))
    except OSError:
        return 0


plain_ends, plain_threads, plain_seconds, plain_log = beam_wedge("plain", PLAIN)
ends, threads, seconds, _ = beam_wedge("chosen", {**PLAIN, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
require(f"without variables the run ends within {LIMIT} s", plain_ends)
require("with them too", ends)
require(f"most threads of a rank, those of MPI included: {plain_threads}, with the variables {threads}",
        0 < plain_threads == threads)
require("the log says so: 2 ranks, 1 thread each", "2 ranks, 1 thread each" in plain_log)
# The cores may be shared with anything; a second thread that spins beside each rank takes twice the time and more.
check_between("CPU time over that with the variables", plain_seconds / seconds, 0, 1.6)

asked = subprocess.run([PROGRAM, "-options_file", "options/beam_wedge.opts", "-dry_run", "-output_dir", os.path.abspath("asked")],
                       cwd=SOURCE, env={**PLAIN, "OMP_NUM_THREADS": "2"}, stdout=subprocess.PIPE, text=True)
require("who asks for two threads gets them", "1 rank, 2 threads each" in asked.stdout)
finish()

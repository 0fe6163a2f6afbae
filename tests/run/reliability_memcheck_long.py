# labels: run long
# timeout: 3600
"""R8 with valgrind: the wet tests on one rank and whole runs on two, with a checkpoint, a restart from it and field output:
no report but those of Open MPI's own file of suppressions and of tests/valgrind.supp. And with -malloc_debug, which marks
PETSc's memory and looks for writes beyond its ends: no complaint, nothing kept. Not for builds with sanitizers."""
import os
import re
import shutil
import subprocess
import sys

from _reliability import BOTH, FRACTURE, command, with_mesh
from _runs import PROGRAM, SOURCE, check, finish, require

WET = os.path.join(os.path.dirname(PROGRAM), "tests", "impact_mpi_tests")
SLOW = "Manufactured*:DamageEquation*:Newmark.*:StepControl.*:Scenario*"  # many steps of what others do once
KILLED = "FieldOutput.AKilledWrite*"  # its children read forbidden memory on purpose
libraries = subprocess.run(["ldd", PROGRAM], stdout=subprocess.PIPE, text=True).stdout
if shutil.which("valgrind") is None or "libasan" in libraries:
    print("     not tried: " + ("a build with sanitizers" if "libasan" in libraries else "valgrind is not installed"))
    sys.exit(0)
valgrind = ["valgrind", "-q", "--error-exitcode=99", "--num-callers=25",
            "--suppressions=" + os.path.join(SOURCE, "tests", "valgrind.supp")]
for folder in ("/usr/share/openmpi", "/usr/lib/x86_64-linux-gnu/openmpi/share/openmpi"):
    if os.path.exists(folder + "/openmpi-valgrind.supp"):
        valgrind.append(f"--suppressions={folder}/openmpi-valgrind.supp")


def run(name, words):
    """Exit status and what was said; the log stays in <name>.log."""
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    with open(name + ".log", "w") as log:
        log.write(done.stdout)
    return done.returncode, done.stdout


def memcheck(name, words):
    code, said = run(name, words)
    reports = re.findall(r"^==\d+== (?=[A-Z])(.*)", said, re.M)
    for report in reports[:5]:
        print("     " + report)
    require(f"{name} ends (status {code})", code == 0)
    check(f"{name}: reports of memcheck", len(reports), 0, 0, relative=False)


def under_valgrind(folder, options):
    words = command(folder, options, 2)
    return words[:3] + valgrind + words[3:]


both = {**with_mesh(BOTH), "checkpoint_every": 2, "output_vis_every": 2}
memcheck("both", under_valgrind("both", {**both, "ts_max_steps": 3}))
memcheck("both_resumed", under_valgrind("both", {**both, "ts_max_steps": 4, "restart": "auto"}))
memcheck("fracture", under_valgrind("fracture", {**with_mesh(FRACTURE), "checkpoint_every": 2, "ts_max_steps": 3}))
for ranks in (1, 2):
    for name, options in (("both", both), ("fracture", with_mesh(FRACTURE))):
        words = command(f"debug_{name}_{ranks}", options, ranks) + ["-malloc_debug", "-malloc_dump"]
        code, said = run(f"debug_{name}_{ranks}", words)
        kept = [line for line in said.splitlines() if re.search(r"^\[\s*\d+\]\s*\d+ bytes|Corrupted|corrupt", line)]
        require(f"{name} on {ranks} rank(s) with -malloc_debug ends (status {code}), nothing kept {kept[:3]}",
                code == 0 and not kept)
memcheck("wet_tests", valgrind + [WET, "--gtest_brief=1", f"--gtest_filter=-{SLOW}:{KILLED}"])
finish()

# labels: run
# timeout: 240
"""Every command of README.md after the set-up runs and succeeds. Runs of the beam are cut short (the last word on the
command line wins), checkpoints are written the sooner, pictures drawn at times that the short run has."""
import os
import re
import shlex
import subprocess

from _runs import SOURCE, cores, finish, require

SHORT = "0.004"


def commands(text):
    for section in ("Run", "Look at results"):
        body = re.search(rf"^## {section}\n(.*?)^## ", text, re.S | re.M).group(1)
        for block in re.findall(r"^```sh\n(.*?)^```", body, re.S | re.M):
            yield from (line for line in block.splitlines() if line.strip())


def shortened(words):
    if any(word.endswith("beam_wedge.opts") for word in words):
        words = ["2" if words[i - 1] == "-checkpoint_every" else word for i, word in enumerate(words)]
        end = "0.006" if "-restart" in words else SHORT
        return words + ["-ts_max_time", end]
    return [f"0.001,{SHORT}" if words[i - 1] == "--times" else word for i, word in enumerate(words)]


# A folder that looks like the top of the repository after a build.
for name in ("options", "meshes", "tools"):
    os.symlink(os.path.join(SOURCE, name), name)
os.makedirs("build/release")
os.symlink(os.environ["IMPACT_PROGRAM"], "build/release/impact")

count = 0
with open(os.path.join(SOURCE, "README.md"), encoding="utf-8") as readme:
    for command in commands(readme.read()):
        count += 1
        with cores(2 if command.startswith("mpirun") else 1):
            done = subprocess.run(shortened(shlex.split(command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            print(done.stdout[-2000:])
        require(f"exit status {done.returncode}: {command}", done.returncode == 0)
# The first run as a user has it, without what the tests set: Open MPI refuses root and too many ranks in its own words, and
# the line that the README names beside them is all that it wants.
bare = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_", "PMIX_", "PRTE_", "HWLOC_", "OMP_", "OPENBLAS_"))}
with open(os.path.join(SOURCE, "README.md"), encoding="utf-8") as readme:
    text = readme.read()
helped = {**bare, **dict(word.split("=", 1) for word in re.search(r"^export (.*)$", text, re.M).group(1).split())}
FIRST = next(line for line in commands(text) if line.startswith("mpirun -n 2")).split() + ["-dry_run", "-output_dir", "first"]
MORE = ["mpirun", "-n", str(2 * os.cpu_count())] + FIRST[3:]
for claim, words, env, said in [("as root" if os.geteuid() == 0 else "as a user", FIRST, bare, "detected an attempt to run as root" if os.geteuid() == 0 else ""),
                                ("more ranks than cores", MORE, {**bare, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}, "not enough slots"),
                                ("one rank without mpirun", FIRST[3:], bare, ""), ("with the README's line", FIRST, helped, ""),
                                ("with it, more ranks than cores", MORE, helped, ""), ("not bound", ["mpirun", "--bind-to", "none"] + FIRST[1:], helped, "")]:
    with cores(2 if words[0] == "mpirun" else 1):
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=env)
    require(f"{claim}: exit status {done.returncode}", (done.returncode != 0) == bool(said) and said in done.stdout)
    require(f"{claim}: the README has Open MPI's words", said in text)
require(f"README.md has commands: {count}", count >= 10)
finish()

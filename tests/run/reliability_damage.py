# labels: run
# timeout: 180
# long: 1800
"""R5: damaged checkpoints end in a message with exit status 4, or the run goes on from an older undamaged one and says
so. No signal, no hang, no silent load. `reliability_damage_long` makes 1000 of them."""
import os
import random
import re
import shutil
import time

from _reliability import BOTH, crashed, difference, history, log_of, run_within, start, with_mesh
from _runs import ENVIRONMENT, check, finish, long, require

WANTED = int(os.environ.get("IMPACT_COUNT", 1000 if long() else 14))
seed = int(os.environ.get("IMPACT_SEED", random.randrange(10**6)))
random.seed(seed)
print(f"     IMPACT_SEED={seed}")

options = {**with_mesh(BOTH), "ts_max_time": 0.03, "outputs": "h", "output_h_type": "csv"}
for key in [k for k in options if k.startswith("output_vis")]:
    del options[key]


def make(folder, more):
    require(f"{folder}: the run ends", run_within(60, folder, {**options, **more}) == 0)


make("good", {"checkpoint_keep": 2})
coarse = {**BOTH, "mesh_set_n_lower": 5, "mesh": os.path.join(os.environ["IMPACT_SOURCE_DIR"], "meshes", "two_blocks.geo"),
          "ts_max_time": 0.02, "outputs": "vis"}
require("other_mesh: the run ends", run_within(60, "other_mesh", coarse) == 0)
make("other_physics", {"material_lower_E": 2e6})
whole = history("good")

names = sorted(os.listdir("good/checkpoints"))
newest, older = "checkpoint_000003", "checkpoint_000002"
require(f"two checkpoints are kept: {names}", len(names) == 4)


def flip(path):
    with open(path, "r+b") as file:
        size = os.path.getsize(path)
        for _ in range(random.randint(1, 4)):
            file.seek(random.randrange(size))
            byte = file.read(1)[0]
            file.seek(-1, 1)
            file.write(bytes([byte ^ (1 << random.randrange(8))]))
    return "bits flipped"


def truncate(path):
    os.truncate(path, random.choice([0, 1, random.randrange(os.path.getsize(path))]))
    return "truncated"


def blank(path):
    size = os.path.getsize(path)
    length = min(size, random.choice([64, 512, 4096]))
    at = random.randrange(size - length + 1)
    with open(path, "r+b") as file:
        file.seek(at)
        if file.read(length) == bytes(length):  # zeros already: nothing would change
            file.seek(0)
        else:
            file.seek(at)
        file.write(bytes(length))
    return "block of zeros"


def extend(path):
    with open(path, "ab") as file:
        file.write(os.urandom(random.randint(1, 5000)))
    return "bytes appended"


def remove(path):
    os.remove(path)
    return "removed"


def junk(path):
    with open(path, "wb") as file:
        file.write(os.urandom(random.randint(1, 10000)))
    return "random bytes"


def folder_in_place(path):
    os.remove(path)
    os.makedirs(path)
    return "a folder instead of a file"


def swap(path):
    other = path.replace(newest, older) if newest in path else path.replace(older, newest)
    os.replace(path, path + ".x")
    os.replace(other, path)
    os.replace(path + ".x", other)
    return "swapped with the other one"


DAMAGES = [flip, flip, flip, truncate, blank, extend, remove, junk, folder_in_place, swap]


def old_version(folder):
    manifest = f"{folder}/checkpoints/{newest}.manifest"
    with open(manifest) as file:
        text = file.read()
    with open(manifest, "w") as file:
        file.write(re.sub(r"^impact checkpoint \d+", "impact checkpoint 0", text))
    return "another version", "fallback"


def from_elsewhere(folder, source):
    for end in (".h5", ".manifest"):
        number = [n for n in sorted(os.listdir(f"{source}/checkpoints")) if n.endswith(end)][-1]
        shutil.copy(f"{source}/checkpoints/{number}", f"{folder}/checkpoints/{number}")
    for name in os.listdir(f"{folder}/checkpoints"):
        if not os.path.exists(f"{source}/checkpoints/{name}") or name.split(".")[0] != number.split(".")[0]:
            os.remove(f"{folder}/checkpoints/{name}")
    return "the checkpoint of a run with another " + source.split("_")[1], "refused"


counts = {"fallback": 0, "refused": 0, "unharmed": 0}
signals, hangs, silent, unclear, longest, late = [], [], [], [], 0.0, 0
for i in range(WANTED):
    shutil.rmtree("hurt", ignore_errors=True)
    shutil.copytree("good", "hurt")
    kind = random.random()
    if kind < 0.03:
        what, expected = old_version("hurt")
    elif kind < 0.08:
        what, expected = from_elsewhere("hurt", random.choice(["other_mesh", "other_physics"]))
    else:
        both = random.random() < 0.3
        damage = random.choice(DAMAGES if not both else [d for d in DAMAGES if d not in (swap, remove)])
        end = random.choice([".h5", ".h5", ".manifest"])
        what = damage(f"hurt/checkpoints/{newest}{end}") + f" ({newest}{end})"
        if both:
            what += ", " + damage(f"hurt/checkpoints/{older}{end}") + " (the older one too)"
        expected = "refused" if both or damage is swap else "fallback"
    begun = time.monotonic()
    code = run_within(10, "hurt", {**options, "restart": "auto"}, env=ENVIRONMENT)
    longest = max(longest, time.monotonic() - begun)
    log = log_of("hurt")
    if code is None:
        # A process can also wait for a busy machine or in the start of MPI: a hang of ours comes again.
        late += 1
        code = run_within(10, "hurt", {**options, "restart": "auto"}, env=ENVIRONMENT)
        log = log_of("hurt")
    if code is None:
        hangs.append(what)
    elif crashed(code):
        signals.append(f"{what}: status {code}")
    elif code == 0:
        at = re.search(r"resumed from hurt/checkpoints/(\S+)\.h5", log)
        # A removed manifest is what a kill leaves: the older one counts, and nothing is to be warned of.
        warned = "is not used: " in log or "removed" in what
        if expected == "refused" or not at or at.group(1) != older or not warned or difference(whole, history("hurt"), exact=True)[0]:
            silent.append(f"{what}: {log.splitlines()[:2]}")
        counts["fallback"] += 1
    else:
        said = [line for line in log.splitlines() if line.startswith("impact: ")]
        clear = code in (2, 4) and said and ("checkpoint" in said[-1]) and "Traceback" not in log
        if expected != "refused" or not clear:
            unclear.append(f"{what}: status {code}, {said[-1:]}")
        counts["refused"] += 1

print(f"     {WANTED} damaged checkpoints: {counts['fallback']} runs went on from the older one, {counts['refused']} were "
      f"refused; longest run {longest:.2f} s; {late} had to be started twice")
for line in signals + hangs + silent + unclear:
    print("     " + line)
check("runs ended by a signal", len(signals), 0, 0, relative=False)
check("runs beyond 10 s", len(hangs), 0, 0, relative=False)
check("silent loads", len(silent), 0, 0, relative=False)
check("unclear ends", len(unclear), 0, 0, relative=False)
finish()

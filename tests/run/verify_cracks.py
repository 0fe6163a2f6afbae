# labels: run
# long: 400
# timeout: 400
"""options/cracks.md: its commands run as they stand (those of the impact, in the short form one of shear too, are cut short), and what it says of the splits holds."""
import os
import re
import shlex
import subprocess

import numpy
import _runs as runs

for name in ("options", "meshes", "tools"):
    os.symlink(os.path.join(runs.SOURCE, name), name)
os.makedirs("build/release")
os.symlink(os.environ["IMPACT_PROGRAM"], "build/release/impact")
with open("options/cracks.md") as file:
    page = file.read()
count = 0
for block in re.findall(r"^```sh\n(.*?)^```", page, re.S | re.M):
    for command in block.splitlines():
        words = shlex.split(command)
        if any("kalthoff" in word for word in words):
            words += ["-ts_max_time", "2 us"]
        if "shear_volumetric" in words and not runs.long():
            words += ["-ts_max_steps", "5"]
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=runs.ENVIRONMENT)
        if done.returncode:
            print(done.stdout[-2000:])
        count += 1
        runs.require(f"exit status {done.returncode}: {command}", done.returncode == 0)
        folder = words[words.index("-output_dir") + 1] if "-output_dir" in words else ""
        if folder:
            split = folder.split("_")[1]
            runs.require(f"{folder}: the log names the split", f", {split} split, " in done.stdout)
runs.require(f"commands: {count}", count == 8)
for picture in re.findall(r"\]\((\w+\.png)\)", page):
    runs.require(f"picture {picture}", os.path.exists("options/" + picture))


def history(name):
    return runs.read_history(name + "/history.csv")


shear = {split: history("shear_" + split) for split in ("spectral", "volumetric")[: 2 if runs.long() else 1]}
runs.check("sheared, spectral: largest load", shear["spectral"]["reaction_push_x"].max(), 528, 0.01)
runs.check("spectral: the crack leaves through the lower corner", shear["spectral"]["crack_plate_tip_y"][-1], 0, 0.05, relative=False)
if runs.long():
    runs.check("sheared, volumetric", shear["volumetric"]["reaction_push_x"].max(), 364, 0.01)
    runs.check("volumetric: straight on", shear["volumetric"]["crack_plate_tip_y"][-1], 0.47, 0.05, relative=False)
press = {split: history("press_" + split) for split in ("spectral", "volumetric")}
load = -press["spectral"]["reaction_press_y"]
runs.check("pressed, spectral: the load at 2 %", load[-1], 4533, 0.01)
runs.require("it has risen in every step", (numpy.diff(load) > 0).all())
runs.check("pressed, volumetric: largest load", -press["volumetric"]["reaction_press_y"].min(), 1198, 0.01)
runs.require("it has fallen before 0.86 %", -press["volumetric"]["reaction_press_y"][-1] < 1150)

# A broken sheet that is pressed gives way in its thickness under the volumetric split; the end of the run says so.
sheet = runs.run("sheet", {
    "ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_n": 8, "plane": "stress", "materials": "solid",
    "material_solid_E": 1000, "material_solid_nu": 0.3, "material_solid_damage": "at2", "material_solid_Gc": 1, "material_solid_gamma": 0.5,
    "bcs": "hold,press,crack", "bc_hold_on": "left", "bc_hold_type": "fix", "bc_press_on": "right", "bc_press_ux": "(-0.6*t)", "bc_press_uy": 0,
    "bc_crack_on": "right", "bc_crack_type": "damage", "bc_crack_value": 1, "ts_dt": 0.1, "ts_max_time": 1,
    "material_solid_split": "volumetric"}, code=5)
runs.require("a broken sheet that is pressed: the remedy is named",
             "broken sheets bear no pressure in their plane, but with -material_solid_split spectral" in sheet.log)
runs.finish()

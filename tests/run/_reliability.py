"""Runs that are disturbed: killed, signalled, given damaged files; and what must hold of them."""
import os
import re
import resource
import shutil
import signal
import subprocess
import time
import xml.etree.ElementTree

import h5py

import _runs
from _histories import difference, field_times, fields_difference, history  # noqa: F401 (for the scripts)
from _runs import BREAKING_BLOCKS, PROGRAM, cores, mesh

FAULTY = os.environ.get("IMPACT_FAULTY", os.path.join(os.path.dirname(PROGRAM), "impact_faulty"))

BOTH = {**BREAKING_BLOCKS, "checkpoint_every": 5, "output_vis_fields": "u,phi"}
CONTACT = {key: value for key, value in BOTH.items()
           if not re.search("lower_(model|sigma_y|hardening|linear_h|damage|Gc|gamma)$|upper_(model|damage)$", key)}
CONTACT["output_vis_fields"] = "u,contact_pressure"
FRACTURE = {
    "ts_type": "static", "units": "mm_t_s_MPa", "mesh_set_n": 6, "materials": "solid", "material_solid_E": 210e3,
    "material_solid_nu": 0.2, "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": 2.7, "material_solid_gamma": 0.3,
    "bcs": "clamp,push", "bc_clamp_on": "left", "bc_clamp_type": "fix", "bc_push_on": "right", "bc_push_ux": "0.012*t",
    "ts_dt": 0.05, "ts_max_time": 1, "checkpoint_every": 5, "outputs": "vis", "output_vis_every": 3,
    "output_vis_fields": "u,phi",
}
MESHES = {id(BOTH): "two_blocks", id(CONTACT): "two_blocks", id(FRACTURE): "block"}


def with_mesh(options):
    """The options with a .msh file in place of the .geo: gmsh runs once, not in every disturbed run."""
    geometry = MESHES[id(options)]
    file = os.path.abspath(geometry + ".msh")
    if not os.path.exists(file):
        _runs.run("make_" + geometry, {**options, "mesh": mesh(geometry + ".geo"), "dry_run": "on"})
        shutil.copy(os.path.join("make_" + geometry, geometry + ".msh"), file)
    return {**{k: v for k, v in options.items() if not k.startswith("mesh_set_")}, "mesh": file}


def command(folder, options, ranks=1, program=PROGRAM):
    words = [program]
    for key, value in options.items():
        text = str(value)
        words += ["-" + key, " " + text if text.startswith("-") else text]
    words += ["-output_dir", folder]
    return ["mpirun", "-n", str(ranks)] + words if ranks > 1 else words


def start(folder, options, ranks=1, program=PROGRAM, fault=None, file_limit=None, env=None):
    """A run in the background; its output goes to <folder>.log."""
    environment = {**os.environ, **({"IMPACT_FAULT": fault} if fault else {}), **(env or {})}
    limit = None if file_limit is None else lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (file_limit, file_limit))
    with open(folder + ".log", "w") as log:
        return subprocess.Popen(command(folder, options, ranks, program), stdout=log, stderr=subprocess.STDOUT,
                                env=environment, preexec_fn=limit)


def family_of(pid):
    """The process and all below it, parents first."""
    children = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                with open(f"/proc/{entry}/stat") as stat:
                    parent = int(stat.read().rsplit(")", 1)[1].split()[1])
                children.setdefault(parent, []).append(int(entry))
            except (OSError, IndexError):
                pass
    found = [pid]
    for one in found:
        found += children.get(one, [])
    return found


def ranks_of(process):
    """Process ids of the program itself, without mpirun."""
    found = []
    for pid in family_of(process.pid):
        try:
            name = os.path.basename(os.readlink(f"/proc/{pid}/exe"))
        except OSError:
            continue
        if name.startswith("impact"):
            found.append(pid)
    return found


def kill(process):
    """SIGKILL to every process of the run at once."""
    for pid in family_of(process.pid):
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    process.wait()


def finish_within(process, seconds):
    """Exit status, or None when it still runs then; it is killed then."""
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        kill(process)
        return None


def run_within(seconds, folder, options, ranks=1, *others, **more):
    """start and finish_within, with cores of its own (_runs.cores); programs with sanitizers have several times as long."""
    with cores(ranks):
        return finish_within(start(folder, options, ranks, *others, **more), seconds * float(os.environ.get("IMPACT_PATIENCE", 1)))


def log_of(folder):
    with open(folder + ".log", errors="replace") as log:
        return log.read()


def wait_for(folder, condition, seconds=20):
    """Waits until `condition()` holds; False when it does not in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.01)
    return False


def rows(folder):
    """Whole rows of the history file."""
    try:
        with open(os.path.join(folder, "history.csv")) as file:
            return max(0, file.read().count("\n") - 1)
    except OSError:
        return 0


def fields_fault(folder, name="vis"):
    """Why the field output is not whole; empty when it is: readable XML, no time doubled, every data set there."""
    path = os.path.join(folder, name + ".xdmf")
    try:
        root = xml.etree.ElementTree.parse(path).getroot()
    except (OSError, xml.etree.ElementTree.ParseError) as error:
        return str(error)
    times = [float(time.get("Value")) for time in root.iter("Time")]
    if sorted(set(times)) != times:
        return f"times are not increasing: {times}"
    for item in root.iter("DataItem"):
        file, data = item.text.strip().split(":", 1)
        with h5py.File(os.path.join(folder, file), "r") as h5:
            if tuple(int(n) for n in item.get("Dimensions").split()) != h5[data].shape:
                return f"{data} has another shape than the .xdmf says"
    return ""


def largest_difference(folder, reference, ranks=1):
    """Of a run from the undisturbed one. On one rank nothing is exempt; on several MUMPS adds in the order of messages."""
    return difference(history(reference), history(folder), exact=ranks == 1)


def crashed(code):
    """Ended by a signal, its own or that of mpirun's child."""
    return code is not None and (code < 0 or code > 128)

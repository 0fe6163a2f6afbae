# labels: run long
# timeout: 900
# processors: 2
"""What a checkpoint costs: 200k dofs with plasticity and damage, written every 50 implicit steps. The write may take 3 % of
the time of 50 steps, at 60 % or more of the speed at which a file of that size is written and synced in one go, in the same
folder before and after the run. The first write of a run lays the file out and is shown beside the later ones."""
import os
import re
import statistics
import time

from _runs import check_between, finish, mesh, run

N, STEPS = 316, 9
OPTIONS = {
    "ts_type": "newmark", "units": "SI", "mesh": mesh("block.geo"), "mesh_set_n": N, "materials": "solid",
    "material_solid_E": 72e9, "material_solid_nu": 0.33, "material_solid_rho": 2800, "material_solid_model": "j2",
    "material_solid_sigma_y": 3e8, "material_solid_hardening": "linear", "material_solid_linear_h": 1e9,
    "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": 5e3, "material_solid_gamma": 0.02,
    # Slow enough to stay elastic: few Newton iterations, so the cheapest steps that a write is held against.
    "bcs": "clamp,push", "bc_clamp_on": "left", "bc_clamp_type": "fix", "bc_push_on": "right", "bc_push_ux": "0.1*t",
    # Waves over many cells a step: implicit steps with a direct solver.
    "ts_dt": 2e-5, "ts_max_time": STEPS * 2e-5, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
    "motion_pc_factor_mat_solver_type": "mumps", "checkpoint_wall": 0,
}


def plain_writes(size, count=5):
    """Seconds to write and sync that many bytes, several times."""
    data, seconds = os.urandom(1 << 20), []
    for _ in range(count):
        begun = time.perf_counter()
        with open("plain", "wb") as file:
            for at in range(0, size, len(data)):
                file.write(data[:size - at])
            file.flush()
            os.fsync(file.fileno())
        seconds.append(time.perf_counter() - begun)
        os.remove("plain")
    return seconds


SIZE = 65_500_000  # roughly; what the file really has is used after the run
before = [t / SIZE for t in plain_writes(SIZE)]
for ranks in (1, 2):
    folder = f"cost_{ranks}"
    done = run(folder, {**OPTIONS, "checkpoint_every": 1, "checkpoint_keep": 2}, ranks=ranks)
    files = sorted(f for f in os.listdir(folder + "/checkpoints") if f.endswith(".h5"))
    size = os.path.getsize(os.path.join(folder, "checkpoints", files[-1]))
    after = [t / size for t in plain_writes(size)]
    plain = statistics.median(before + after) * size
    before = after
    first, *writes = [float(t) for t in re.findall(r"checkpoint \S+: \d+ bytes in ([\d.]+) s", done.log)]
    write = statistics.median(writes)
    wall = re.search(r"finished at .* steps in (\d+):(\d+)", done.log)
    step = (60 * int(wall.group(1)) + int(wall.group(2)) - first - sum(writes)) / int(done["step"][-1])
    print(f"     {2 * (N + 1) ** 2} dofs, {ranks} rank(s): checkpoint of {size / 1e6:.1f} MB in {write:.3f} s (median of "
          f"{len(writes)}: {min(writes):.3f} to {max(writes):.3f}; the first {first:.3f}), {size / 1e6 / write:.0f} MB/s; "
          f"plain write and fsync {plain:.3f} s, {size / 1e6 / plain:.0f} MB/s; a step {step:.2f} s")
    check_between(f"{ranks} rank(s): share of a run that writes every 50 implicit steps", write / (50 * step), 0, 0.03)
    check_between(f"{ranks} rank(s): share of the first write", first / (50 * step), 0, 0.03)
    check_between(f"{ranks} rank(s): speed of the write over that of a plain one", plain / write, 0.6, 100)
finish()

# labels: run long
# timeout: 1800
"""The long forms of scripts to which no "# long:" can give a test, because another script has that name: all that they had
before twins, finer meshes and other numbers of ranks left the short ones."""
import os
import subprocess
import sys

from _runs import finish, require

HERE = os.path.dirname(os.path.abspath(__file__))
for name in ("verify_contact_gates", "verify_contact_held", "verify_contact_hertz", "verify_contact_ironing", "verify_energy_damage",
             "verify_explicit", "verify_obstacle_mass", "verify_path", "verify_self_contact"):
    os.makedirs(name)
    done = subprocess.run([sys.executable, os.path.join(HERE, name + ".py")], cwd=name, env={**os.environ, "IMPACT_LONG": "1"},
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout)
    require(f"{name} in its long form: status {done.returncode}", done.returncode == 0)
finish()

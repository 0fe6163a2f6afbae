# labels: run long
# timeout: 900
"""The long form of verify_contact_friction_space.py: every enforcement, meshes, slopes and numbers of ranks."""
import os
import runpy

os.environ["IMPACT_LONG"] = "1"
runpy.run_path(os.path.join(os.path.dirname(os.path.abspath(__file__)), "verify_contact_friction_space.py"), run_name="__main__")

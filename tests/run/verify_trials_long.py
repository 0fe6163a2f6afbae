# labels: run long
# timeout: 3600
"""The long form of verify_trials.py."""
import os
import runpy

os.environ["IMPACT_LONG"] = "1"
runpy.run_path(os.path.join(os.path.dirname(os.path.abspath(__file__)), "verify_trials.py"), run_name="__main__")

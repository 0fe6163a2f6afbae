# labels: run long
# timeout: 1800
"""The long form of reliability_kills.py."""
import os
import runpy

os.environ["IMPACT_LONG"] = "1"
runpy.run_path(os.path.join(os.path.dirname(os.path.abspath(__file__)), "reliability_kills.py"), run_name="__main__")

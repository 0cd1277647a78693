"""Entry point of `python -m benchmarks`."""

import sys

from benchmarks.app import load
from swarm_commander.cli.main import run_app

if __name__ == "__main__":
    sys.exit(run_app("python -m benchmarks", load))

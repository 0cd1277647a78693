"""`swarm-up` over the fakes without ROS."""

import os
import sys

from swarm_commander.cli import main as cli
from swarm_commander.run import local_run, process_run
from swarm_commander.run.processes import restarts

for name, module in (
    ("WORLD", "world"),
    ("HOST", "host"),
    ("RUNNER", "runner"),
    ("RECORDER", "recorder"),
):
    local_run.MODULES[getattr(local_run, name)] = f"tests.fakes.plain.{module}"  # type: ignore[index]
if os.environ.get("FAKE_RUNNER") in ("mute", "dies"):
    local_run.MISSION_LIMIT = 1.0
if silence := os.environ.get("FAKE_SILENCE"):
    local_run.WORLD_SILENCE = float(silence)
if grace := os.environ.get("FAKE_GRACE"):
    process_run.GRACE = float(grace)
if os.environ.get("FAKE_HOST") == "deaths":
    restarts.FIRST_PAUSE = 0.05
sys.exit(cli.swarm_up())

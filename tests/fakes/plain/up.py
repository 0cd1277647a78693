"""`swarm-up` over the fakes without ROS."""

import os
import sys
from dataclasses import replace

from swarm_commander.cli import main as cli
from swarm_commander.run import local_run, process_table, supervision
from swarm_commander.run.processes import restarts

FAKES = {"world": "world", "navigators": "host", "mission": "runner", "recorder": "recorder"}
process_table.TABLE = tuple(
    replace(row, module=f"tests.fakes.plain.{FAKES[row.name]}") if row.name in FAKES else row
    for row in process_table.TABLE
)
if os.environ.get("FAKE_RUNNER") in ("mute", "dies"):
    local_run.MISSION_LIMIT = 1.0
if silence := os.environ.get("FAKE_SILENCE"):
    local_run.WORLD_SILENCE = float(silence)
if grace := os.environ.get("FAKE_GRACE"):
    supervision.GRACE = float(grace)
if os.environ.get("FAKE_HOST") == "deaths":
    restarts.FIRST_PAUSE = 0.05
sys.exit(cli.swarm_up())

"""`swarm-up` over the stand-ins without ROS."""

import os
import sys

from swarm_commander import bringup, cli

for name, module in (
    ("WORLD", "world"),
    ("HOST", "host"),
    ("RUNNER", "runner"),
    ("RECORDER", "recorder"),
):
    bringup.MODULES[getattr(bringup, name)] = f"tests.standins.plain_{module}"  # type: ignore[index]
if os.environ.get("STANDIN_RUNNER") == "mute":
    bringup.MISSION_LIMIT = 1.0
sys.exit(cli.swarm_up())

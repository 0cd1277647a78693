"""`swarm-up` over the stand-ins without ROS."""

import sys

from swarm_commander import bringup, cli

for name, module in (("WORLD", "world"), ("HOST", "host"), ("RUNNER", "runner")):
    bringup.MODULES[getattr(bringup, name)] = f"tests.standins.plain_{module}"  # type: ignore[index]
sys.exit(cli.swarm_up())

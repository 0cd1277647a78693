"""Parts of `swarm-up --role` beside a run on one host: profiles of DDS, and the robots' side."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from rich.text import Text

from swarm_commander.hosts.robots_plan import RobotsPlan
from swarm_commander.hosts.robots_run import RobotsRun, robots_report
from swarm_commander.run import terminal
from swarm_commander.run.process_table import ROBOTS_TABLE
from swarm_commander.run.results.progress import Progress
from swarm_commander.run.results.report import write_report
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.rundir import RunFolder, create_run_folder, write_env_sh
from swarm_commander.run.supervision import Supervision
from swarm_commander.run.terminal import complain
from swarm_common.middleware import dds_profile, ros_env
from swarm_common.model.breaches import shortened
from swarm_common.process.home import log_to
from swarm_run.command_line import COMPONENT_FAILED, OK
from swarm_run.domain import domain_id
from swarm_setup.build import ensure_interfaces

TOOLS_PROFILE = "fastdds_host.xml"  # of all that is not a navigator
ROBOTS_PROFILE = "fastdds_robots.xml"


def write_profile(path: Path, own: str, peers: Sequence[dds_profile.Peers], domain: int) -> Path:
    """Write a profile of DDS; return its path."""
    path.write_text(dds_profile.profile(own, peers, domain), encoding="utf-8")
    return path


def use_profile(folder: RunFolder, own_address: str, world_address: str) -> None:
    """Bind all processes started here to one address, and let them look for the world's host."""
    peers = dds_profile.peers_of_tools(own_address, world_address)
    path = write_profile(folder.configs / TOOLS_PROFILE, own_address, peers, domain_id())
    ros_env.use_profile(str(path))


def bring_up_robots(plan: RobotsPlan) -> int:
    """Run the robots' side of a swarm; return the exit code."""
    ensure_interfaces()
    folder = create_run_folder(plan.run_dir, datetime.now())
    use_profile(folder, plan.own_address, plan.world_address)
    peers = dds_profile.peers_of_robots(plan.own_address, plan.world_address, plan.processes)
    robots_profile = write_profile(
        folder.configs / ROBOTS_PROFILE, plan.own_address, peers, plan.domain
    )
    write_env_sh(folder, os.environ)
    log_to(folder.logs / "ros", os.environ)
    console = terminal.console()
    statistics = RunStatistics.of((), has_mission=True)  # the world's host knows their names
    progress = Progress(console, statistics, time.monotonic)
    progress.note(
        f"{len(plan.robots)} robots on {plan.own_address}, for the world at {plan.world_address}"
    )
    progress.phase("looking for the world's host")
    progress.start()
    run = Supervision(ROBOTS_TABLE, folder, progress, statistics, restarts=plan.restart)
    side = RobotsRun(plan, run, robots_profile)
    try:
        run.run(side)
    finally:
        progress.stop()
    code = COMPONENT_FAILED if run.failures else OK
    if problem := write_report(folder.report, robots_report(side, run, plan, code)):
        code = COMPONENT_FAILED
        complain(problem)
    for line in shortened(run.failures, "failures"):
        console.print(Text(line, style="red"), soft_wrap=True)
    console.print(f"report: {folder.report}", highlight=False, soft_wrap=True)
    return code

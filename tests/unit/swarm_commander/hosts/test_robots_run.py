"""A robots' host: what its navigators say of the files that were made for them."""

import io
import time
from datetime import datetime
from pathlib import Path

import pytest
from rich.console import Console

from swarm_commander.hosts.robots_plan import RobotsPlan
from swarm_commander.hosts.robots_run import RobotsRun
from swarm_commander.hosts.run_description import compose
from swarm_commander.run.process_table import ROBOTS_TABLE
from swarm_commander.run.results.progress import Progress
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.rundir import create_run_folder
from swarm_commander.run.supervision import Supervision
from swarm_common.files.params_io import default_parameters, nest
from swarm_common.process import messages as say
from swarm_run.params import load_overrides

ROBOTS = ("Srobot1", "Srobot2")


class Run(Supervision):
    """Starts nobody."""

    def __init__(self, folder):
        plan = RobotsPlan(
            robots=(1, 2),
            pack=1,
            own_address="10.0.0.2",
            world_address="10.0.0.1",
            domain=0,
            label="second",
            secret="",
        )
        statistics = RunStatistics.of((), has_mission=True)
        progress = Progress(Console(file=io.StringIO()), statistics, time.monotonic)
        run_folder = create_run_folder(folder, datetime(2026, 1, 1))
        super().__init__(ROBOTS_TABLE, run_folder, progress, statistics)
        self.side = RobotsRun(plan, self, Path())
        self._parts = (self.side,)

    @property
    def refusal(self):
        return self._refusal

    def describe(self, text):
        self.side._description_path.write_text(text, encoding="utf-8")

    def start(self, name, config, *flags):
        pass


@pytest.mark.parametrize(
    ("problem", "is_theirs"),
    [
        ("vx_samples is 1; it must be from 2 to 100", True),
        ("max_vel_x is 5.0; it must be from 0 to 1", False),
    ],
)
def test_a_wrong_value_is_named_in_the_file_of_the_worlds_host(tmp_path, problem, is_theirs):
    """The message named the copy on this host, which its user never wrote."""
    path = tmp_path / "mine.yaml"
    path.write_text("/**:\n  ros__parameters: {vx_samples: 1}\n", encoding="utf-8")
    overrides = load_overrides(path, list(ROBOTS), default_parameters())
    trees = {
        name: {f"/{name}/navigator": {"ros__parameters": nest(overrides.for_robot(name))}}
        for name in ROBOTS
    }
    run = Run(tmp_path / "run")
    run.describe(compose("run", "1", {}, trees, None, {}, overrides.source).to_text())
    for event in (
        say.WorldFound(),
        say.Refused(f"{run.folder.params / 'Srobot2.yaml'}: {problem}"),
    ):
        run.receive(event)
    theirs = f"{path} on the world's host: /**: {problem}"
    assert run.refusal == (
        theirs if is_theirs else f"{run.folder.params / 'Srobot2.yaml'}: {problem}"
    )

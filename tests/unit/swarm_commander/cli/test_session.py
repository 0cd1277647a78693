"""The end of a session of swarm-up."""

import io
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console

from swarm_commander.cli import session
from swarm_commander.run.processes.restarts import Restarts
from swarm_commander.run.processes.usage import UsageMeter
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_run.spec import RunSpec


@pytest.mark.parametrize(
    ("stopped", "code", "said"),
    [(True, 130, "stopped before the robots drove\n"), (False, 3, "there is no verdict")],
)
def test_a_start_that_is_stopped_says_so_in_one_line(tmp_path, stopped, code, said):
    plan: Any = SimpleNamespace(spec=RunSpec(swarm_size=1, report=False), alive=("Srobot1",))
    folder: Any = SimpleNamespace(
        path=tmp_path, verdict=tmp_path / "verdict.json", report=tmp_path / "report.json"
    )
    run: Any = SimpleNamespace(
        statistics=RunStatistics.of(["Srobot1"], has_mission=False),
        verdict={}, failures=[], incidents=[], wall_time=1.0, active_after_wall=None,
        restarts=Restarts(), usage=UsageMeter(), is_stopped_by_user=stopped, never_active=True,
        ending_signal=2, folder=folder,
    )  # fmt: skip
    local: Any = SimpleNamespace(complete=lambda _: None)
    console = Console(width=100, file=io.StringIO())
    assert session._conclude(plan, run, local, console) == code
    text = console.file.getvalue()
    assert text == said if stopped else said in text
    assert folder.report.exists()

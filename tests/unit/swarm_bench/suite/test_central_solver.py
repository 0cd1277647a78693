"""`swarm-bench traffic --central-solver`: the solver drives, or the run is refused in words."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from swarm_bench import cli
from swarm_central import movingai
from tests.fakes import solver

PROGRAM = Path(solver.__file__)
SCENARIO = """
world: doorway
mission: change_rooms
robots: 4
time_limit: {4: 200}
"""
LIMIT = 60.0  # [s] of wall time, on a busy machine


@pytest.fixture
def command(tmp_path, monkeypatch):
    """Return the command, in a folder of its own; solvers have their files there, too."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TMPDIR", str(tmp_path / "files"))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.setenv("SOLVER_COUNT", str(tmp_path / "count"))
    (tmp_path / "files").mkdir()
    (tmp_path / "two_rooms.yaml").write_text(SCENARIO, encoding="utf-8")
    return [
        "traffic", "--scenario", "two_rooms.yaml", "--seeds", "0", "--json", "runs.jsonl",
        "--method", "central-mapf", "--central-solver", str(PROGRAM),
    ]  # fmt: skip


def run(monkeypatch, command, mode):
    """Run the command in this process; return its exit code and the line that it wrote."""
    monkeypatch.setenv("SOLVER_MODE", mode)
    monkeypatch.setattr("sys.argv", ["swarm-bench", *command])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    (line,) = Path("runs.jsonl").read_text(encoding="utf-8").splitlines()
    assert list(Path("files").iterdir()) == []
    return caught.value.code, json.loads(line)


def test_a_solver_drives_all_the_way(command, monkeypatch, capsys):
    code, line = run(monkeypatch, command, "right")
    assert code == 0, capsys.readouterr().out
    assert line["goals_reached"] == 4
    assert line["conditions"]["central.solver"] == str(PROGRAM)
    assert line["centre"]["plans"] > 0
    assert line["centre"]["plans_by_pibt"] == line["centre"]["failed_plans"] == 0


@pytest.mark.parametrize(
    ("mode", "told"),
    [
        ("collide", "and robot"),
        ("stand", "its goal is"),
        ("swap", "change places"),
        ("jump", "one of the four cells beside its own"),
        ("start", "begins at"),
        ("wall", "on no free cell"),
        ("twice", "expected all 4"),
        ("gap", "expected step 1"),
        ("nan", "nan"),
        ("text", "'and so on'"),
        ("empty", "without a plan"),
        ("unsolved", "solved=0"),
        ("none", "without a file"),
        ("fail", "no way\u00a0found"),
        ("crash", "signal 11"),
        ("hang", "was killed 0.2 s after its time of 1.5 s for 4 robots: still searching"),
    ],
)
def test_a_wrong_solver_is_refused_and_nothing_else_drives_in_its_name(
    command, monkeypatch, capsys, mode, told
):
    if mode == "hang":
        monkeypatch.setattr(movingai, "GRACE", 0.2)
        command += ["--set", "central.solver_time=1.5"]
    code, line = run(monkeypatch, command, mode)
    assert code == 2
    assert line["refused"] is True
    assert told in line["error"]
    assert f"s of simulated time --central-solver {PROGRAM}" in line["error"]
    assert "goals_reached" not in line
    assert f"seed 0: refused: {line['error']}" in capsys.readouterr().out


def test_a_solver_that_fails_later_ends_the_run_there(command, monkeypatch):
    monkeypatch.setenv("SOLVER_MODE", "late")
    code, line = run(monkeypatch, command, "late")
    assert code == 2
    assert float(line["error"].split()[1]) > 1.0  # [s] of simulated time
    assert "gave up with exit code 1: no way\u00a0found" in line["error"]


def test_another_program_of_the_same_name_is_another_run(command, monkeypatch):
    program = Path("solver")
    command[-1] = "solver"
    for text in ("", "# another\n"):
        program.write_text(PROGRAM.read_text(encoding="utf-8") + text, encoding="utf-8")
        program.chmod(0o755)
        monkeypatch.setenv("SOLVER_MODE", "right")
        monkeypatch.setattr("sys.argv", ["swarm-bench", *command])
        with pytest.raises(SystemExit):
            cli.main()
    first, second = map(json.loads, Path("runs.jsonl").read_text(encoding="utf-8").splitlines())
    assert first["origin"]["inputs"] != second["origin"]["inputs"]
    assert first["trajectory_sha256"] == second["trajectory_sha256"]


@pytest.mark.timeout(120)
def test_an_interrupt_leaves_neither_processes_nor_files(command, tmp_path):
    call = [sys.executable, "-c", "from swarm_bench.cli import main; main()", *command]
    env = os.environ | {"SOLVER_MODE": "hang"}
    count = tmp_path / "count"
    with subprocess.Popen([*call, "--set", "central.solver_time=600"], env=env) as bench:
        end = time.monotonic() + LIMIT
        while not (count.exists() and count.read_text()):
            assert time.monotonic() < end
            assert bench.poll() is None
            time.sleep(0.05)
        bench.send_signal(signal.SIGTERM)
        assert bench.wait(LIMIT) == 128 + signal.SIGTERM
    child = int(count.read_text())
    assert not psutil.pid_exists(child) or psutil.Process(child).status() == psutil.STATUS_ZOMBIE
    assert list((tmp_path / "files").iterdir()) == []

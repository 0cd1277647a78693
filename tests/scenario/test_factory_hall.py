"""`swarm-up` for real: world, navigators and missions in the factory hall."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

ROOT = Path(__file__).resolve().parents[2]
SHARED_MEMORY = Path("/dev/shm")
pytestmark = pytest.mark.timeout(420)  # a busy machine takes its time


class Swarm:
    """Starts `swarm-up` runs; knows what they left behind."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.process: subprocess.Popen[str] | None = None

    def start(self, *flags: str, name: str = "run") -> None:
        code = "from swarm_commander.cli.main import swarm_up; swarm_up()"
        self.process = subprocess.Popen(
            (sys.executable, "-c", code, *flags, "--run-dir", str(self.folder / name)),
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            cwd=self.folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def wait_for(self, text: str) -> None:
        """Read its output up to a line with `text`."""
        assert self.process is not None
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if text in line:
                return
        pytest.fail(f"it ended without {text}")

    def finish(self, limit: float = 250.0) -> tuple[int, str]:
        assert self.process is not None
        try:
            output, _ = self.process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            self.process.terminate()
            output, _ = self.process.communicate(timeout=30)
            pytest.fail(f"not done after {limit:g} s:\n{output}")
        return self.process.returncode, output

    def run(self, *flags: str, name: str = "run", limit: float = 250.0) -> tuple[int, str]:
        self.start(*flags, name=name)
        return self.finish(limit)

    def report(self, name: str = "run") -> dict[str, Any]:
        text = (self.folder / name / "report.json").read_text(encoding="utf-8")
        report = json.loads(text)
        assert isinstance(report, dict)
        return report

    def addresses(self) -> set[str]:
        """Return the addresses that UDP sockets of its processes are bound to."""
        assert self.process is not None
        everything = psutil.Process(self.process.pid).children(recursive=True)
        return {c.laddr.ip for p in everything for c in p.net_connections("udp")}

    def navigators(self) -> list[psutil.Process]:
        """Return the processes of the robots, in order."""
        assert self.process is not None
        everything = psutil.Process(self.process.pid).children(recursive=True)
        hosts = [
            p for p in everything if "swarm_nav.launch.fork_server_main" in " ".join(p.cmdline())
        ]
        return sorted((p for p in hosts if p.ppid() in {h.pid for h in hosts}), key=lambda p: p.pid)


def segments() -> set[str]:
    return {path.name for path in SHARED_MEMORY.glob("*fast*")}


@pytest.fixture
def swarm(tmp_path: Path) -> Iterator[Swarm]:
    """Yield a starter of swarms; nothing of theirs may be left at the end."""
    before = segments()
    swarm = Swarm(tmp_path)
    yield swarm
    if swarm.process is not None and swarm.process.poll() is None:
        swarm.process.kill()
        swarm.process.communicate()
    deadline = time.monotonic() + 20.0
    while left := [p for p in psutil.process_iter(["cmdline"]) if _is_of(p, tmp_path)]:
        assert time.monotonic() < deadline, left
        time.sleep(0.1)
    assert segments() <= before


def _is_of(process: psutil.Process, folder: Path) -> bool:
    return any(str(folder) in part for part in process.info["cmdline"] or [])


def wait_until(condition: Any, limit: float = 200.0) -> None:
    deadline = time.monotonic() + limit
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.1)


MISSION = ("--mission", "loading_route", "--until-done", "--headless", "--speed", "max")


def check_is_flawless(report: dict[str, Any], goals: int) -> None:
    assert report["goals"] == {"sent": goals, "reached": goals, "failed": 0, "pending": 0}
    assert report["collisions"] == {"robot_robot": 0, "robot_world": 0}
    assert report["late_ticks"] == 0
    assert report["min_clearance"] > 0.0


def busy_process() -> subprocess.Popen[bytes]:
    return subprocess.Popen((sys.executable, "-c", "while True: pass"))


@pytest.mark.long  # that the bench moves robots as the graph does is a test that always runs
def test_equal_seeds_give_equal_trajectories_on_a_busy_machine_too(swarm):
    flags = ("--swarm-size", "3", "--goals-per-robot", "2", "--seed", "3", *MISSION)
    code, output = swarm.run(*flags, name="calm")
    assert code == 0, output
    busy = busy_process()
    try:
        code, output = swarm.run(*flags, name="busy")
    finally:
        busy.kill()
        busy.wait()
    assert code == 0, output
    calm, busied = swarm.report("calm"), swarm.report("busy")
    for report in (calm, busied):
        check_is_flawless(report, goals=6)
    assert len(calm["trajectory_sha256"]) == 64
    assert calm["trajectory_sha256"] == busied["trajectory_sha256"]
    assert calm["makespan"] == busied["makespan"]
    assert calm["sim_time"] == pytest.approx(calm["makespan"])


def test_the_others_finish_when_one_navigator_is_killed(swarm):
    swarm.start("--swarm-size", "3", "--goals-per-robot", "1", "--no-restart", *MISSION)
    swarm.wait_for("running")
    swarm.navigators()[1].kill()
    code, output = swarm.finish()
    assert code == 3, output
    assert "Srobot2 died: killed by SIGKILL" in output
    robots = swarm.report()["robots"]
    assert [robots[f"Srobot{n}"]["goals_reached"] for n in (1, 3)] == [1, 1]
    assert robots["Srobot2"]["goals_failed"] == 1


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)]
)
def test_without_a_mission_the_swarm_waits_for_its_operator(swarm, number):
    swarm.start("--swarm-size", "2")
    swarm.wait_for("running")
    assert swarm.addresses() == {"127.0.0.1"}
    code = "from swarm_commander.cli.main import commander; commander()"
    result = subprocess.run(
        (sys.executable, "-c", code, "Srobot2", "--goal", "3.0", "3.0", "0.0"),
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert "reached" in result.stdout
    time.sleep(2.0)  # for the robot's last status to arrive
    assert swarm.process is not None
    swarm.process.send_signal(number)
    code, output = swarm.finish(limit=60.0)
    assert code == 0, output
    assert swarm.report()["goals"] == {"sent": 1, "reached": 1, "failed": 0, "pending": 0}


def test_a_swarm_that_waits_for_its_operator_ends_with_a_report_at_sigterm(swarm):
    swarm.start("--swarm-size", "2")
    swarm.wait_for("running")
    assert swarm.process is not None
    swarm.process.send_signal(signal.SIGTERM)
    code, output = swarm.finish(limit=60.0)
    assert code == 0, output
    assert swarm.report()["goals"] == {"sent": 0, "reached": 0, "failed": 0, "pending": 0}


def test_nothing_is_left_of_a_killed_swarm(swarm):
    swarm.start("--swarm-size", "2")
    wait_until(lambda: len(swarm.navigators()) == 2)
    time.sleep(2.0)
    assert swarm.process is not None
    swarm.process.kill()
    swarm.process.communicate()


def test_a_station_inside_a_wall_is_bad_input(swarm):
    world = swarm.folder / "hall"
    shutil.copytree(ROOT / "worlds" / "slim_blockage", world)
    sites = world / "sites.yaml"
    text, count = re.subn(r"loader_3: .*", "loader_3: [-8.4, 0.0, 0.0]", sites.read_text("utf-8"))
    assert count == 1
    sites.write_text(text, encoding="utf-8")
    code, output = swarm.run("--world", str(world / "world.sdf"), "--swarm-size", "1")
    assert code == 2
    assert "loader_3" in output.splitlines()[-1]


@pytest.mark.slow
def test_twenty_robots_reach_their_first_station(swarm):
    flags = ("--swarm-size", "20", "--goals-per-robot", "1", *MISSION)
    code, output = swarm.run(*flags, limit=360.0)
    assert code == 0, output
    check_is_flawless(swarm.report(), goals=20)


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize("seed", range(5))
def test_five_robots_work_through_the_hall(swarm, seed):
    code, output = swarm.run("--swarm-size", "5", "--seed", str(seed), *MISSION, limit=800.0)
    assert code == 0, output
    check_is_flawless(swarm.report(), goals=40)


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("seed", range(3))
def test_twenty_robots_work_through_the_hall(swarm, seed):
    code, output = swarm.run("--swarm-size", "20", "--seed", str(seed), *MISSION, limit=1700.0)
    assert code == 0, output
    check_is_flawless(swarm.report(), goals=160)

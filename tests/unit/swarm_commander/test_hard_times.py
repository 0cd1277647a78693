"""Disks that are full, terminals that are gone, folders that are shared: the report is true."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from datetime import datetime
from pathlib import Path

import psutil
import pytest

from swarm_commander.run.processes.supervisor import describe_exit
from swarm_commander.run.results.report import write_report
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.rundir import create_run_folder
from swarm_common.files.storage import write_whole
from swarm_common.model.breaches import MissedGoal
from swarm_common.model.errors import ConfigError
from swarm_common.process import messages as say
from swarm_common.process.signals import SignalCounter
from tests.fakes.programs import run_program
from tests.fakes.small_disk import fill, small_disk
from tests.fakes.swarm_up import DOMAIN, MISSION, ROOT, wait_for

OTHER_DOMAIN = "229"


@pytest.fixture
def disk(tmp_path):
    with small_disk(tmp_path / "disk") as folder:
        yield folder


def test_a_full_disk_leaves_no_half_report_and_says_so(up, disk):
    up.run_dir = disk / "run"
    process = up.start(*MISSION, "--no-report", runner="slow")
    wait_for((up.run_dir / "config" / "begun").exists)
    fill(disk)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 3, output
    assert "Traceback" not in errors + output
    assert "report.json cannot be written: No space left on device" in errors
    assert "goals reached" in output  # the summary is shown all the same
    assert not (up.run_dir / "report.json").exists()


def test_a_disk_that_is_full_at_the_start_is_one_clear_failure(up, disk):
    up.run_dir = disk / "run"
    fill(disk)
    code, output, errors = up.run()
    assert code in (2, 3)
    assert "No space left on device" in output + errors
    assert "Traceback" not in output + errors


def test_a_recorder_that_hangs_at_the_end_is_no_success(up):
    """Its recording lacked the rest; the report said nothing, and the exit code was 0."""
    code, output, _ = up.run(*MISSION, "--record", recorder="hangs", grace="1.0")
    assert code == 3, output
    report = up.report()
    assert report["goals"]["reached"] == 3
    (failure,) = report["failures"]
    assert failure.startswith("the recorder process did not end within 1 s and was killed")
    assert " ".join(failure.split()[:8]) in " ".join(output.split())


def test_a_recording_that_cannot_be_shown_is_no_success(up):
    """Without a map; the exit code was 0, and no word said so."""
    code, output, _ = up.run(*MISSION, "--record", recorder="lacks")
    assert code == 1, output
    assert up.report()["recording"]["missing"] == ["/map"]
    text = " ".join(output.split())
    assert "the recording lacks 8 messages: 7 of /Srobot1/odom, 1 of /map" in text
    assert "the recording has no /map" in text


def test_a_recorder_without_room_does_not_end_the_swarm(up):
    code, output, _ = up.run(*MISSION, "--record")
    assert code == 3
    assert "No space left on device" in output
    assert up.report()["goals"]["reached"] == 3


def test_a_file_stays_as_it_was_if_the_new_one_does_not_fit(disk):
    path = disk / "report.json"
    write_whole(path, '{"old": 1}')
    fill(disk)
    assert "No space left" in write_report(path, {"new": "x" * 100_000})
    assert json.loads(path.read_text(encoding="utf-8")) == {"old": 1}
    assert [file.name for file in disk.iterdir() if file.name.startswith(".")] == []


def test_the_reader_of_the_output_may_leave(up):
    process = up.start(*MISSION, "--no-report")
    assert process.stdout.readline()
    process.stdout.close()
    errors = process.stderr.read()
    assert process.wait(60) == 0, errors
    assert errors == ""
    assert up.report()["goals"]["reached"] == 3


def test_files_of_the_current_folder_are_no_modules(up):
    """The processes of a run imported `json.py` of the user's folder in place of Python's."""
    (up.folder / "json.py").write_text("raise SystemExit('not this one')", encoding="utf-8")
    code, output, errors = up.run(*MISSION, "--no-report")
    assert code == 0, output + errors


@pytest.mark.parametrize("home", ["", "/proc"])
def test_ros_logs_to_the_folder_of_the_run(up, monkeypatch, home):
    """It logged to the home folder, without which rclpy did not start."""
    monkeypatch.delenv("ROS_LOG_DIR", raising=False)
    if home:
        monkeypatch.setenv("HOME", home)
    process = up.start()
    wait_for(lambda: len(up.left_running()) >= 4)
    for child in psutil.Process(process.pid).children():
        wait_for(lambda c=child: "ROS_LOG_DIR" in c.environ())  # a fork has it from its exec on
        assert child.environ()["ROS_LOG_DIR"] == str(up.run_dir / "logs" / "ros")
    process.terminate()
    process.communicate(timeout=60)


def test_two_runs_cannot_have_one_folder(up):
    process = up.start()
    wait_for(lambda: len(up.left_running()) >= 4)
    marks = sorted(path.name for path in up.run_dir.rglob("*"))
    second = run_program(
        (sys.executable, "-m", "tests.fakes.plain.up", "--run-dir", str(up.run_dir)),
        {"ROS_DOMAIN_ID": OTHER_DOMAIN},
        cwd=up.folder,
    )
    assert second.returncode == 2
    assert second.stderr.startswith("swarm-up: another run writes to")
    assert second.stderr.count("\n") == 1
    assert set(marks) <= {path.name for path in up.run_dir.rglob("*")}
    process.terminate()
    process.communicate(timeout=60)
    assert DOMAIN != OTHER_DOMAIN
    assert up.report()["exit_code"] == 0


def test_runs_of_the_same_second_have_two_folders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    now = datetime(2026, 1, 2, 3, 4)
    monkeypatch.setattr(Path, "exists", lambda _: False)  # neither sees the other's in time
    first, second = create_run_folder(None, now), create_run_folder(None, now)
    assert second.path.name == f"{first.path.name}-2"
    assert (tmp_path / "runs" / "latest").readlink() == Path(second.path.name)


def test_a_disk_without_locks_and_links_has_runs(tmp_path, monkeypatch):
    """NFS locks only files that are open for writing, exFAT has no links."""

    def refuse(*_):
        raise OSError(errno.EBADF, os.strerror(errno.EBADF))

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("fcntl.flock", refuse)
    monkeypatch.setattr(Path, "symlink_to", refuse)
    folder = create_run_folder(None, datetime(2026, 1, 2, 3, 4))
    assert folder.logs.is_dir()
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [folder.path.name]


@pytest.mark.parametrize("make", [Path.touch, lambda path: path.symlink_to("none")])
def test_runs_that_is_no_folder_is_refused(tmp_path, monkeypatch, make):
    monkeypatch.chdir(tmp_path)
    make(tmp_path / "runs")
    with pytest.raises(ConfigError, match="cannot write the run folder"):
        create_run_folder(None, datetime(2026, 1, 2, 3, 4))


def test_nohup_is_respected():
    """The handler of the run took SIGHUP back that nohup had switched off."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with SignalCounter() as counter:
            os.kill(os.getpid(), signal.SIGHUP)
            assert counter.count == 0
            signal.raise_signal(signal.SIGTERM)
            assert counter.count == 1
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_folder_whose_name_is_no_text_is_refused(tmp_path):
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/run-\xff"))
    with pytest.raises(ConfigError, match="not UTF-8") as caught:
        create_run_folder(path, datetime(2026, 1, 2, 3, 4))
    str(caught.value).encode()
    assert not path.exists()


def test_goals_that_were_never_sent_are_not_counted_as_sent():
    statistics = RunStatistics.of(["Srobot1"], has_mission=True)
    statistics.apply(say.MissionLoaded(3))
    statistics.apply(say.GoalSent("Srobot1", "a"))
    for name in "abc":  # the robot died on its way to the first
        statistics.apply(say.GoalMissed(MissedGoal("Srobot1", name, 5.0, "")))
    assert (statistics.sent, statistics.reached, statistics.failed, statistics.pending) == (
        1,
        0,
        3,
        0,
    )
    assert statistics.unfinished == []


def test_sigbus_is_explained():
    assert "/dev/shm" in describe_exit(-signal.SIGBUS)


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.1, 0.2, 0.3])
def test_an_early_ctrl_c_ends_without_a_traceback(tmp_path, delay):
    code = (
        "from swarm_commander.cli.main import swarm_up\n"
        "import sys; sys.stdout.write('here'); sys.stdout.flush(); swarm_up()"
    )
    process = subprocess.Popen(
        (sys.executable, "-c", code, "--swarm-size", "0"),
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.read(4) == "here"
    time.sleep(0.02 + delay)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert "Traceback" not in errors
    assert process.returncode in (-signal.SIGINT, 130, 2)

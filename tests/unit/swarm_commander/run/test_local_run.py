"""`swarm-up` as a process, over fakes of the world, the navigators and the mission."""

import signal
import time

import psutil
import pytest

from tests.fakes.swarm_up import DOMAIN, MISSION, Up, wait_for


def test_a_mission_ends_with_a_report(up):
    code, output, errors = up.run(*MISSION)
    assert code == 0, output + errors
    report = up.report()
    assert report["goals"] == {"sent": 3, "reached": 3, "failed": 0, "pending": 0}
    assert report["makespan"] == 10.0
    assert report["throughput_per_minute"] == 18.0
    assert report["active_after_wall"] > 0.0
    assert report["trajectory_sha256"] == "ab" * 32
    assert report["near_misses"] == 2
    assert (report["goal_duration"], report["fairness"]) == ({"median": 8.0, "worst": 8.0}, 1.0)
    assert report["breaches"] == {"collisions": [], "missed_goals": [], "unfinished_goals": []}
    assert set(report["robots"]) == {"Srobot1", "Srobot2", "Srobot3"}
    assert "goals reached" in output
    assert (up.run_dir / "env.sh").read_text(encoding="utf-8").count(f"ROS_DOMAIN_ID={DOMAIN}") == 1
    assert len(list((up.run_dir / "params").iterdir())) == 3


def test_robots_that_are_broken_from_the_start_are_named(up):
    params = up.folder / "broken.yaml"
    params.write_text("/world: {ros__parameters: {broken: {Srobot3: [0.0, 0.0, 0.0]}}}\n")
    _, output, _ = up.run(*MISSION, "--params", str(params))
    assert "1 robot is broken: Srobot3" in output
    assert up.report()["broken"] == ["Srobot3"]


def test_a_missed_goal_makes_it_one(up):
    code, output, _ = up.run(*MISSION, runner="miss")
    assert code == 1
    line = "Srobot2 missed shipping at t = 10.0 s: error 208: every way is closed [by walls]"
    assert " ".join(output.split()).count(line) == 2, "when it happens, and in the summary"


def test_a_collision_makes_it_one(up):
    code, output, _ = up.run(*MISSION, world="collision")
    assert code == 1
    line = "collision of Srobot1 and Srobot3 at (1.00, -2.00), t = 11.4 s"
    assert " ".join(output.split()).count(line) == 2, "when it happens, and in the summary"
    assert up.report()["breaches"]["collisions"][0]["robots"] == ["Srobot1", "Srobot3"]


def test_a_died_navigator_makes_it_three_but_the_others_go_on(up):
    code, output, _ = up.run(*MISSION, "--no-restart", host="death")
    assert code == 3
    assert "Srobot2 died: killed by SIGKILL" in output
    assert up.report()["goals"]["reached"] == 3


def test_a_navigator_that_died_is_started_anew_and_the_run_may_still_be_good(up):
    flags = ("--mission", "loading_route", "--duration", "12")
    code, output, _ = up.run(*flags, host="death", world="calm", runner="slow")
    assert code == 0, output
    assert "Srobot2 died: killed by SIGKILL; it is restarted in 1 s" in output
    report = up.report()
    assert report["failures"] == []
    assert "Srobot2 died" in report["incidents"][0]


def test_a_navigator_that_dies_again_and_again_stays_down(up):
    process = up.start("--mission", "loading_route", host="deaths", runner="slow")
    wait_for(lambda: (up.run_dir / "logs" / "deaths").exists())
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=60)
    assert process.returncode == 3, output
    report = up.report()
    assert report["restarts"] == 5
    assert "Srobot2 died: killed by SIGKILL more than 5 times; it stays down" in output
    assert "Srobot2 died" in report["failures"][0]
    assert up.report()["robots"]["Srobot2"]["restarts"] == 5


@pytest.mark.parametrize("world", ["early", "silent"])
def test_without_the_whole_run_or_a_verdict_the_exit_code_is_not_zero(up, world):
    """A world that ends by itself, with exit code 0, or gives no verdict."""
    code, output, _ = up.run("--duration", "12", world=world)
    assert code == 3, output
    word = "the world process ended: exit code 0" if world == "early" else "there is no verdict"
    assert word in " ".join(output.split())


def test_a_world_that_hangs_is_found_out_in_time(up):
    moods = {"world": "stopped", "runner": "slow", "silence": "6.0"}
    begin = time.monotonic()
    code, output, _ = up.run("--mission", "loading_route", **moods)
    assert code == 3, output
    assert 5.0 < time.monotonic() - begin < 45.0, "limit 6 s, start and end"
    assert "the world process hangs: nothing was heard of it for 6 s" in " ".join(output.split())
    report = up.report()
    assert report["collisions"] == {"robot_robot": None, "robot_world": None}
    assert report["trajectory_sha256"] is None
    assert report["has_verdict"] is False


def test_a_stopped_run_without_a_verdict_is_not_a_good_one(up):
    process = up.start("--mission", "loading_route", world="stopped", runner="slow", grace="2.0")
    children = psutil.Process(process.pid).children
    wait_for(lambda: any(child.status() == psutil.STATUS_STOPPED for child in children()))
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=60)
    assert process.returncode == 3, output


def test_time_begins_without_a_mission_process_that_hangs(up):
    code, output, _ = up.run("--duration", "12", runner="mute")
    assert code == 3, output
    said = "the mission process does not hear the robots"
    assert said in " ".join(output.split())
    assert [said in failure for failure in up.report()["failures"]] == [True]


def test_a_crash_of_the_world_makes_it_three_and_says_its_last_words(up):
    code, output, _ = up.run(*MISSION, world="crash")
    assert code == 3
    words = " ".join(output.split())
    assert "exit code 7; its log ends with: the physics engine fell over" in words


@pytest.mark.parametrize(
    ("moods", "message"),
    [
        ({"world": "refuse"}, "swarm-up: station loader_3 lies inside a wall\n"),
        ({"host": "refuse"}, "swarm-up: mine.yaml: /**: max_vel_x is -1; it must be positive\n"),
    ],
)
def test_input_that_a_process_refuses_is_bad_input(up, moods, message):
    text = "/**: {ros__parameters: {max_vel_x: -1.0}}\n"
    (up.folder / "mine.yaml").write_text(text, encoding="utf-8")
    code, _, errors = up.run("--params", "mine.yaml", **moods)
    assert (code, errors) == (2, message)
    assert not (up.run_dir / "report.json").exists()


def test_brackets_in_the_name_of_a_folder_are_letters(up):
    """They were taken for markup: a wrong path was told, or the run ended with a traceback."""
    up.run_dir = up.folder / "a[red]" / "b[" / "x]"
    code, output, errors = up.run("--duration", "12")
    assert (code, errors) == (0, "")
    assert f"report: {up.run_dir}/report.html" in output


def test_a_duration_in_which_no_robot_became_active_is_a_failure(up):
    """Where its user may have few processes, no navigator ever lived; the exit code was 0."""
    code, output, _ = up.run("--duration", "12", host="mute")
    assert code == 3
    words = " ".join(output.split())
    assert "time was up before these were active: Srobot1, Srobot2, Srobot3" in words


@pytest.mark.parametrize(("flags", "code"), [(MISSION[:2], 0), (MISSION, 1)])
def test_only_until_done_has_to_finish_within_the_duration(up, flags, code):
    ended, output, _ = up.run(*flags, "--duration", "12", world="calm", runner="slow")
    assert ended == code
    assert ("Srobot1 did not get to shipping: silent" in output) == bool(code)
    assert up.report()["goals"] == {"sent": 1, "reached": 0, "failed": 0, "pending": 3}


def test_the_user_may_stop_a_mission(up):
    process = up.start(*MISSION, runner="slow")
    wait_for((up.run_dir / "config" / "begun").exists)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=60)
    assert process.returncode == 0, output
    assert up.report()["goals"]["pending"] == 3


def test_a_mission_that_dies_before_the_first_goal_is_reached_goes_on(up):
    """The next one had "sent no goal" for as long as all robots had been active."""
    code, output, _ = up.run(*MISSION, "--no-report", runner="dies")
    assert code == 0, output
    assert up.report()["goals"]["reached"] == 3
    assert "the mission process ended: exit code 1" in up.report()["incidents"][0]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_everything_and_the_report_is_written(up, number):
    process = up.start()
    wait_for((up.run_dir / "config" / "active").exists)
    time.sleep(1.0)
    process.send_signal(number)
    assert process.wait(timeout=60) == 0
    process.communicate()
    assert up.report()["goals"]["sent"] == 0


def test_ctrl_c_before_the_robots_drive_waits_for_nobody(up):
    process = up.start(world="deaf", host="mute")
    wait_for((up.run_dir / "config" / "active").exists)
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=60)
    assert process.returncode == 130, output
    assert output.splitlines()[-1] == "stopped before the robots drove"
    assert time.monotonic() - begin < 9.0, "a process that hears no signal is given 10 s else"


def test_nothing_outlives_a_killed_swarm_up(up):
    process = up.start()
    wait_for(lambda: len(up.left_running()) >= 7)
    process.kill()
    process.communicate()


def test_a_second_swarm_in_the_domain_is_refused(up, tmp_path):
    process = up.start()
    wait_for(lambda: len(up.left_running()) >= 4)
    other = Up(tmp_path / "other")
    other.folder.mkdir()
    try:
        code, _, errors = other.run()
    finally:
        assert not other.end()
    assert code == 2
    assert errors.startswith(f"swarm-up: ROS domain {DOMAIN} is in use by another swarm")
    process.terminate()
    process.communicate(timeout=60)


def test_a_process_that_ignores_the_wish_to_end_is_killed_on_the_second_ctrl_c(up):
    process = up.start(world="deaf")
    wait_for((up.run_dir / "config" / "active").exists)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)

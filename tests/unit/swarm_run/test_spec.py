import importlib.util
import shlex
import subprocess
import sys
from datetime import datetime
from pathlib import Path

import pytest

from swarm_commander.cli.commander_command import Moment, StatusConsole
from swarm_commander.run.rundir import create_run_folder, write_env_sh
from swarm_common.model.engines import usual_engine
from swarm_common.model.errors import ConfigError
from swarm_run.domain import domain_id
from swarm_run.spec import RunSpec, parse_speed
from swarm_sim.world.world import WorldConfig

NOW = datetime(2024, 5, 6, 7, 8, 9)


@pytest.mark.parametrize("size", [1, 7, 11, 97, 100])
def test_any_size_up_to_the_limit_will_do(size):
    options = RunSpec(swarm_size=size).check()
    assert options.robot_names[-1] == f"Srobot{size}"
    assert len(options.robot_names) == size


def test_more_than_the_limit_is_a_wish_and_the_default_speed_real_time():
    assert RunSpec(swarm_size=101, over_limit=True, pack=2).check().size == 101
    assert parse_speed(None, in_real_time=True) == 1.0
    assert parse_speed(None, in_real_time=False) is None
    assert parse_speed("max", in_real_time=True) is None
    assert parse_speed("2.5", in_real_time=False) == 2.5


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"swarm_size": 0}, "--swarm-size is 0"),
        ({"swarm_size": 101}, "--over-limit"),
        ({"swarm_size": 200, "over_limit": True}, "put several in each with --pack 10"),
        ({"swarm_size": 1000, "over_limit": True, "pack": 50}, "with --pack 84"),
        ({"goals_per_robot": 0, "mission": "a"}, "--goals-per-robot is 0"),
        ({"duration": 0.0}, "--duration is 0"),
        ({"duration": float("nan")}, "--duration is nan"),
        ({"until_done": True}, "--until-done needs a --mission"),
        ({"laps": 2}, "--laps needs a --mission"),
        ({"goals_per_robot": 2}, "--goals-per-robot needs a --mission"),
        ({"mission": "a", "autostart": False}, "leave out --no-autostart"),
        ({"mission": "a", "until_done": True, "free_run": True}, "--duration as a limit"),
    ],
)
def test_impossible_options_are_refused(values, message):
    with pytest.raises(ConfigError, match=message):
        RunSpec(**values).check()


@pytest.mark.parametrize("text", ["fast", "0", "-1", "inf", "nan", ""])
def test_a_speed_is_a_positive_number_or_max(text):
    with pytest.raises(ConfigError, match="--speed"):
        parse_speed(text, in_real_time=False)


@pytest.mark.parametrize(("text", "domain"), [(None, 0), ("", 0), ("42", 42), ("232", 232)])
def test_the_domain_comes_from_the_environment(text, domain):
    assert domain_id({} if text is None else {"ROS_DOMAIN_ID": text}) == domain


@pytest.mark.parametrize("text", ["233", "-1", "x", "1.5"])
def test_an_impossible_domain_is_refused(text):
    with pytest.raises(ConfigError, match="ROS_DOMAIN_ID"):
        domain_id({"ROS_DOMAIN_ID": text})


def test_a_run_folder_is_new_or_cleared_of_a_run_and_of_nothing_else(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first, second = create_run_folder(None, NOW), create_run_folder(None, NOW)
    assert first.path != second.path
    assert (tmp_path / "runs" / "latest").resolve() == second.path
    assert second.logs.is_dir()
    folder = create_run_folder(tmp_path / "mine", NOW)
    for path in (folder.report, folder.params / "Srobot9.yaml", folder.path / "notes.txt"):
        path.write_text("", encoding="utf-8")
    folder.release()
    again = create_run_folder(tmp_path / "mine", NOW)
    assert not again.report.exists()
    assert not list(again.params.iterdir())
    assert (again.path / "notes.txt").exists()
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"cannot write the run folder .*--run-dir"):
        create_run_folder(tmp_path / "file" / "run", NOW)
    (tmp_path / "params").mkdir()
    (tmp_path / "params" / "precious.yaml").write_text("mine")
    with pytest.raises(ConfigError, match="not empty and no earlier run's folder"):
        create_run_folder(tmp_path, NOW)
    assert (tmp_path / "params" / "precious.yaml").read_text() == "mine"


def test_another_terminal_finds_the_environment(tmp_path):
    folder = create_run_folder(tmp_path / "mine", NOW)
    write_env_sh(folder, {"ROS_DOMAIN_ID": "5", "HOME": "/nowhere"})
    text = (folder.path / "env.sh").read_text(encoding="utf-8")
    assert "export ROS_DOMAIN_ID=5" in text
    assert "HOME" not in text
    script = f". {shlex.quote(str(folder.path / 'env.sh'))}; command -v swarm-commander; echo $PATH"
    bare = {"PATH": "/usr/bin:/bin"}
    done = subprocess.run(
        ("sh", "-c", script), env=bare, capture_output=True, text=True, check=True
    )
    where, path = done.stdout.splitlines()
    assert where == str(Path(sys.prefix) / "bin" / "swarm-commander")
    assert path == f"{sys.prefix}/bin:/usr/bin:/bin"


def test_the_environment_of_one_swarm_replaces_that_of_another(tmp_path):
    """After an env.sh with a domain, one without left the commands in the other domain."""
    write_env_sh(create_run_folder(tmp_path / "other", NOW), {"ROS_DOMAIN_ID": "5"})
    write_env_sh(create_run_folder(tmp_path / "mine", NOW), {})
    script = ". ./other/env.sh; . ./mine/env.sh; printf ${ROS_DOMAIN_ID-none}"
    done = subprocess.run(
        ("sh", "-eu", "-c", script), cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout == "none"


def moment(sim_time, state, place=0):
    return Moment(sim_time, state, "", "loader_3" if place else "", place, 3.2, 14.0)


def test_the_narrator_speaks_on_change_and_now_and_then():
    console = StatusConsole("Srobot3", period=2.0)
    assert console.line("1/8 loader_3", moment(1.0, "driving")) == (
        "Srobot3  1/8 loader_3     driving: 3.20 m, 14 s to go"
    )
    assert console.line("1/8 loader_3", moment(1.5, "driving")) is None
    held = console.line("1/8 loader_3", moment(2.0, "holding", 2))
    assert held is not None
    assert "holding for loader_3, place 2" in held
    assert console.line("1/8 loader_3", moment(3.9, "holding", 2)) is None
    assert console.line("1/8 loader_3", moment(4.0, "holding", 2)) is not None


def test_without_pybullet_robots_drive_planar_and_wheels_are_refused(monkeypatch):
    usual_engine.cache_clear()
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    try:
        assert usual_engine() == "planar"
        with pytest.raises(ConfigError, match="PyBullet is not installed"):
            RunSpec(drive="wheels").check()
        with pytest.raises(ConfigError, match="engine bullet: PyBullet is not installed"):
            WorldConfig(engine="bullet")
        assert RunSpec(drive="planar").check().drive == "planar"
    finally:
        usual_engine.cache_clear()

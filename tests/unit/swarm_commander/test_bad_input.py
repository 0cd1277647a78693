"""Bad input to `swarm-up`: one clear message on stderr, exit code 2, and nothing is started."""

import socket

import pytest

from swarm_commander.cli import main as cli
from swarm_commander.run.supervision import Supervision
from swarm_run.domain import DomainLock
from tests.fakes.charging import hall_with_chargers, waffle_with_battery

DOMAIN = 230


@pytest.fixture
def refusal(tmp_path, monkeypatch, capsys):
    """Yield a function that runs swarm-up with flags and returns its only line on stderr."""

    def must_not_start(_, spec):
        pytest.fail(f"{spec.name} was started")

    def run(*flags):
        monkeypatch.setattr("sys.argv", ["swarm-up", *flags])
        with pytest.raises(SystemExit) as caught:
            cli.swarm_up()
        assert caught.value.code == 2
        output, errors = capsys.readouterr()
        assert output == ""
        assert errors.startswith("swarm-up: ")
        assert errors.count("\n") == 1
        return errors

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_DOMAIN_ID", str(DOMAIN))
    monkeypatch.setattr(Supervision, "_spawn", must_not_start)
    yield run
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("flags", "advice"),
    [
        (["--world", "Hall_Three"], "unknown world 'Hall_Three'; did you mean 'hall_three'"),
        (["--world", "PLAYGROUND"], "did you mean 'playground'"),
        (
            ["--world", "hall.yaml"],
            "is a floor plan; build a world of it first: swarm-map new hall",
        ),
        (["--mission", "deliver"], "did you mean './deliver.yaml'"),
    ],
)
def test_files_of_the_current_folder_are_proposed(refusal, tmp_path, flags, advice):
    for name in ("hall_three/world.sdf", "hall.yaml", "hall.PNG", "deliver.yaml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert advice in refusal(*flags)


def test_a_swarm_that_runs_is_named_before_its_port(refusal):
    lock = DomainLock(DOMAIN)
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = str(server.getsockname()[1])
        try:
            assert f"ROS domain {DOMAIN} is in use" in refusal("--viewer", "--port", port)
        finally:
            lock.release()
        assert "--port" in refusal("--viewer", "--port", port)


@pytest.mark.parametrize(
    ("flags", "hint"),
    [
        (("Srobot1", "--goal", "5", "5"), "--goal: X Y YAW in the map"),
        (("Srobot1", "-goal", "5", "5", "0"), "did you mean --goal?"),
        (("Srobot1", "--goal", "nan", "1", "0"), "--goal is nan 1.0 0.0; expected finite numbers"),
        (("Srobot1", "--all"), "Srobot1 and --all exclude each other"),
        (("--goal", "1", "1", "0"), "name a robot, like Srobot3, or give --all"),
    ],
)
def test_the_commander_says_how_it_is_written(flags, hint, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["swarm-commander", *flags])
    with pytest.raises(SystemExit) as caught:
        cli.commander()
    assert caught.value.code == 2
    assert hint in capsys.readouterr().err


@pytest.mark.parametrize(
    ("flags", "parts"),
    [
        (["--swarm-size", "0"], ["--swarm-size is 0", "1 or more"]),
        (["--swarm-size", "101"], ["101", "--over-limit"]),
        (["--swarm-size", "ten"], ["--swarm-size", "ten"]),
        (["--swarm-sise", "3"], ["--swarm-sise", "--swarm-size"]),
        (["--world", "slim_blokage"], ["unknown world 'slim_blokage'", "'slim_blockage'"]),
        (["--robot", "none/own.urdf"], ["there is no file or folder 'none/own.urdf'"]),
        (["--world", "none.sdf"], ["there is no file or folder 'none.sdf'"]),
        (["--robot", "turtlebot_waffle"], ["unknown robot", "'turtlebot3_waffle'"]),
        (["--map", "none.yaml"], ["none.yaml"]),
        (["--speed", "quick"], ["--speed is 'quick'"]),
        (["--viewer", "--headless"], ["--viewer and --headless exclude each other"]),
        (["--rviz", "Srobot9"], ["unknown robot 'Srobot9' in --rviz", "did you mean"]),
        (
            ["--record", "--record-rate", "0"],
            ["--record-rate is 0.0; expected a number, more than 0"],
        ),
        (["--record", "--record-topics", "scam"], ["'scam' matches no topic", "scan"]),
        (["--fleet", "mixed", "--swarm-size", "5"], ["--swarm-size is 5", "30 robots"]),
        (["--fleet", "mixed", "--robot", "turtlebot3_waffle"], ["--robot and --fleet exclude"]),
        (["--viewer", "--port", "70000"], ["--port is 70000; expected 1 to 65535"]),
        (["--viewer", "--viewer-host", "192.0.2.1"], ["cannot listen on 192.0.2.1:8080"]),
    ],
    ids=" ".join,
)
def test_flags(refusal, flags, parts):
    message = refusal(*flags)
    for part in parts:
        assert part in message


MAP = "image: map.pgm\nresolution: {resolution}\norigin: {origin}\nnegate: 0\n"
MAP += "occupied_thresh: 0.65\nfree_thresh: 0.25\n"


@pytest.mark.parametrize(
    ("resolution", "origin", "image", "part"),
    [
        ("0.05", "[0, 0, 0]", None, "map.pgm"),
        ("0.05", "[0, 0, 0]", b"P5 40 30 255\n" + bytes(12), "map.pgm"),
    ],
)
def test_a_map(refusal, tmp_path, resolution, origin, image, part):
    text = MAP.format(resolution=resolution, origin=origin)
    (tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
    if image is not None:
        (tmp_path / "map.pgm").write_bytes(image)
    message = refusal("--map", "mine.yaml")
    assert part in message
    assert "mine.yaml" in message or "map.pgm" in message


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("/**:\n  ros__parameters:\n    max_vel_xx: 0.1\n", "'max_vel_x'"),
        ("/**:\n  ros__parameters:\n    max_vel_x: fast\n", "'max_vel_x' is 'fast'"),
        ("/**:\n  ros__parameters:\n    max_vel_x: [\n", "line 4"),
    ],
)
def test_a_parameter_file(refusal, tmp_path, text, part):
    (tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
    message = refusal("--params", "mine.yaml")
    assert part in message
    assert "mine.yaml" in message


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("groups:\n  - {model: turtlebot3_burger, count: 101}\n", "--over-limit"),
        (
            "groups:\n  - {model: turtlebot3_burger, count: 1, mission: loading_route}\n",
            "a mission in the --fleet needs a --mission",
        ),
    ],
)
def test_a_fleet_file(refusal, tmp_path, text, part):
    (tmp_path / "fleet.yaml").write_text(text, encoding="utf-8")
    assert part in refusal("--fleet", "fleet.yaml")


@pytest.mark.parametrize(
    ("battery", "charging", "parts"),
    [
        (
            {"capacity": 0.0},
            None,
            ["robot.yaml: battery.capacity is 0.0; expected a number, more than 0"],
        ),
        ({"charge_power": -1}, None, ["battery.charge_power is -1"]),
        ({}, ["charger_4"], ["sites.yaml: charging", "charger_4", "charger_1"]),
        ({"capacity": 0.05}, [], ["Srobot1 needs", "Wh", "no station charges it", "charging: ["]),
    ],
)
def test_a_battery(
    refusal, tmp_path, battery, charging,
    parts,
):  # fmt: skip
    more = {} if charging is None else {"charging": charging}
    world, robot = hall_with_chargers(tmp_path, **more), waffle_with_battery(tmp_path, **battery)
    error = refusal("--world", str(world), "--robot", str(robot), "--mission", "loading_route")
    assert [part for part in parts if part not in error] == []


def test_a_mission_file(refusal, tmp_path):
    (tmp_path / "mine.yaml").write_text("route:\n  - stations: [loader_9]\n", encoding="utf-8")
    message = refusal("--mission", "mine.yaml")
    assert "unknown station 'loader_9'" in message
    assert "sites.yaml" in message


def test_a_run_folder_where_nobody_may_write_or_that_is_a_file(refusal, tmp_path):
    assert "cannot write the run folder" in refusal("--run-dir", "/proc/swarm/run")
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert "cannot write the run folder" in refusal("--run-dir", "file")


@pytest.mark.parametrize("flag", ["world", "robot", "map", "params", "mission", "fleet", "run-dir"])
@pytest.mark.parametrize("name", ["x" * 300, "x" * 300 + ".yaml", "y/" * 3000 + "a.sdf"])
def test_names_that_are_too_long_are_one_message(refusal, flag, name):
    refusal(f"--{flag}", name)

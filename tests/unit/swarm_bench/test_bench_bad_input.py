"""Bad input to `swarm-bench`: one clear message on stderr, exit code 2, and nothing is run."""

import shutil

import pytest

from swarm_bench import cli
from swarm_bench.execution import cluster
from swarm_bench.execution.processes import LocalExecutor
from swarm_common.files.resources import share_directory


@pytest.fixture
def refusal(tmp_path, monkeypatch, capsys):
    """Return a function that runs swarm-bench with flags and returns its line on stderr."""

    def must_not_run(*_):
        yield pytest.fail("something was run")

    def run(*flags):
        monkeypatch.setattr("sys.argv", ["swarm-bench", *flags])
        with pytest.raises(SystemExit) as caught:
            cli.main()
        assert caught.value.code == 2
        output, errors = capsys.readouterr()
        assert output == ""
        assert errors.startswith("swarm-bench: ")
        assert errors.count("\n") == 1
        return errors

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(LocalExecutor, "run", must_not_run)
    monkeypatch.setattr(cluster, "ANSWER", 0.5)
    return run


@pytest.mark.parametrize(
    ("flags", "parts"),
    [
        (["--scenario", "slim_blokage"], ["unknown scenario 'slim_blokage'", "'slim_blockage'"]),
        (["--robots", "0"], ["--robots is 0", "from 1 to 1000"]),
        (["--robots", "ten"], ["--robots is 'ten'"]),
        (["--scenario", "doorway", "--robots", "150"], ["room for", "75 are asked for", "2 areas"]),
        (["--scenario", "circle", "--robots", "60"], ["room for 44", "60 are asked for"]),
        (["--seeds", "x"], ["--seeds is 'x'", "0-19"]),
        (["--loss", "1.5"], ["loss is 1.5"]),
        (["--engine", "gazebo"], ["unknown engine 'gazebo'", "bullet, planar"]),
        (["--method", "mine"], ["unknown method 'mine'", "module:Class, orca, ours"]),
        (["--set", "traffic.safety_margin"], ["expected NAME=VALUE"]),
        (["--set", "traffic.safety_margin=-1"], ["safety_margin is -1"]),
        (["--jobs", "0"], ["--jobs is 0"]),
        (["--jobs", "2", "--ros"], ["--ros takes all cores"]),
        (["--ros", "--method", "dwa"], ["--method dwa needs the bench"]),
        (
            ["--method", "orca", "--set", "controller.plugin=tests.fakes.plugins:Pursuit"],
            ["controller.plugin is 'tests.fakes.plugins:Pursuit'", "--method orca does not use it"],
        ),
        (
            ["--method", "central-mapf", "--set", "planner.plugin=tests.fakes.plugins:Dijkstra"],
            ["planner.plugin is", "--method central-mapf does not use it"],
        ),
        (["--method", "mine:Driver"], ["cannot import mine", "'mine:Driver'"]),
        (["--robots", "9..4"], ["'9..4'", "FIRST..LAST:STEP"]),
        (["--shard", "3/2"], ["--shard is '3/2'"]),
        (["--shard", "auto"], ["no task of a Slurm array"]),
        (["--cluster", "tcp://127.0.0.1:1"], ["no scheduler answers at tcp://127.0.0.1:1"]),
        (["--ros", "--cluster", "local"], ["leave out --cluster"]),
        (["--json", "none/there.jsonl"], ["none/there.jsonl"]),
    ],
)
def test_bad_flags_of_traffic_are_refused(refusal, flags, parts):
    message = refusal("traffic", *(flags if "--scenario" in flags else ["--scenario", "circle"]),
                      *([] if "--scenario" in flags else flags))  # fmt: skip
    for part in parts:
        assert part in message


def test_a_mission_to_own_places_needs_one_for_each_robot(refusal, tmp_path):
    folder = tmp_path / "few"
    shutil.copytree(share_directory() / "worlds" / "hall_12", folder)
    sites = folder / "sites.yaml"
    places = "places: [[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0]]\n"
    sites.write_text(sites.read_text(encoding="utf-8") + places, encoding="utf-8")
    scenario = f"world: {folder}\nmission: own_place\nrobots: [3]\n"
    (tmp_path / "few.yaml").write_text(scenario, encoding="utf-8")
    message = refusal("traffic", "--scenario", "few.yaml")
    assert "needs a place for each of 3 robots" in message


def test_a_file_that_holds_no_results_is_refused(refusal, tmp_path):
    (tmp_path / "notes.txt").write_text("makespan 12\n", encoding="utf-8")
    message = refusal("traffic", "--scenario", "circle", "--json", "notes.txt")
    assert "notes.txt, line 1 is no result" in message
    assert "no results" in refusal_of_empty(refusal, tmp_path)


def refusal_of_empty(refusal, folder):
    (folder / "empty.jsonl").write_text("", encoding="utf-8")
    return refusal("report-traffic", "empty.jsonl", "-o", "out.md")


@pytest.mark.parametrize(
    ("flags", "parts"),
    [
        (["--seconds", "0"], ["--seconds is 0", "positive"]),
        (["--seconds", "1e9"], ["duration is 1000000000.0; expected a number from 0"]),
        (["--warm-up", "1800"], ["--warm-up is 1800", "less than --seconds 1800"]),
        (["--precision", "0"], ["--precision is '0'", "3%"]),
        (["--budget", "30"], ["--budget is '30'", "30min"]),
        (["--shard", "1/2", "--budget", "1h"], ["--shard needs a fixed list"]),
        (["--sweep", "loss"], ["--sweep is 'loss'", "NAME=VALUE,VALUE"]),
        (["--sweep", "loss=0,0"], ["different values"]),
        (["--sweep", "controller.max_vel=1"], ["unknown axis 'max_vel' in --sweep"]),
        (["-o", "sweep.pdf"], ["sweep.pdf", ".html"]),
        (["-o", "none/sweep.html"], ["no folder none"]),
    ],
)
def test_bad_flags_of_sweep_are_refused(refusal, flags, parts):
    message = refusal("sweep", *flags)
    for part in parts:
        assert part in message

"""Results on disk, and the document that is written from them."""

import io
import json
from pathlib import Path

import pytest
from rich.console import Console

from swarm_bench.cli import _load
from swarm_bench.execution.processes import LocalExecutor
from swarm_bench.execution.task import Done
from swarm_bench.runs import inputs
from swarm_bench.runs.origin import here
from swarm_bench.runs.result_builder import identity
from swarm_bench.runs.ros_run import result_of_report, run_on_graph, spec_of
from swarm_bench.suite.command import bench_app
from swarm_bench.suite.report import traffic_report
from swarm_bench.suite.selection import select, suite_sweeps
from swarm_bench.suite.summary import summarise
from swarm_bench.suite.sweep import RunSweep, key_of_options, read_results
from swarm_bench.suite.table import COLUMNS
from swarm_common.model.errors import ConfigError
from tests.fakes.lines import add_lines
from tests.fakes.results import result


class FakeExecutor:
    """Returns flawless results, and notes the seeds."""

    def __init__(self):
        self.asked: list[int] = []

    def run(self, runner, items, pack):
        for index, item in enumerate(items):
            self.asked.append(item.seed)
            yield Done(index, result(**identity(item)), here())

    def close(self):
        pass


def test_a_killed_sweep_continues(tmp_path):
    path = tmp_path / "runs.jsonl"
    options = select("slim_blockage", [20], [0, 1, 2])
    executor = FakeExecutor()
    RunSweep(options[1:2], path, executor).run(Console(file=io.StringIO()))
    with path.open("a", encoding="utf-8") as file:
        file.write('{"schema": 1, "scen')  # killed here
    console = Console(file=io.StringIO(), width=170)
    results = RunSweep(options, path, executor).run(console)
    said = console.file.getvalue()
    assert f"1 of 3 runs are in {path} already" in said
    assert executor.asked == [1, 0, 2]
    assert sorted(item.seed for item in results) == [0, 1, 2]
    assert [item.seed for item in read_results(path)] == [1, 0, 2]


def test_other_inputs_or_conditions_are_other_runs(tmp_path):
    mission, path = tmp_path / "own.yaml", tmp_path / "runs.jsonl"
    scenario = tmp_path / "row.yaml"
    scenario.write_text(f"mission: {mission}\nrobots: [2]\n", encoding="utf-8")
    executor, console = FakeExecutor(), Console(file=io.StringIO(), width=170)
    for station in ("loader_1", "loader_2", "loader_1"):
        inputs._values.clear()  # each is a process of its own
        mission.write_text(f"route:\n  - stations: [{station}]\n", encoding="utf-8")
        RunSweep(select(str(scenario), (), [0]), path, executor).run(console)
    assert executor.asked == [0, 0]  # the third is the first
    said = console.file.getvalue()
    assert said.count("1 results in") == 2  # the second, and beside the third the second's
    with pytest.raises(ConfigError, match=r"line 1.*line 2.*different inputs"):
        read_results(path)
    (plain,) = select("slim_blockage", [20], [0])
    (lossy,) = select("slim_blockage", [20], [0], loss=0.2)
    (tuned,) = select("slim_blockage", [20], [0], settings=["traffic.safety_margin=0.06"])
    keys = {key_of_options(item, ros=False) for item in (plain, lossy, tuned)}
    assert len({*keys, key_of_options(plain, ros=True)}) == 4


def test_lines_count_once_and_what_is_none_is_named(tmp_path):
    first, second = tmp_path / "a.jsonl", tmp_path / "b.jsonl"
    for path, wall_time in ((first, 9.0), (second, 11.0)):
        add_lines(path, [result(wall_time=wall_time, origin=here("1"))])
    assert len(read_results(first, second)) == 1
    add_lines(second, [result(trajectory_sha256="1", origin=here("1"))])
    with pytest.raises(ConfigError, match=r"a\.jsonl, line 1 .*b\.jsonl, line 2 .*trajectory"):
        read_results(first, second)
    path = tmp_path / "runs.jsonl"
    path.write_text(json.dumps({"scenario": "circle"}) + "\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"runs\.jsonl, line 1 is no result"):
        read_results(path)


def test_the_document_has_rows_targets_flaws_and_a_comparison():
    runs = [result(seed=seed, makespan=600.0 + seed) for seed in range(3)]
    runs += [result(seed=0, engine="ros", makespan=640.0, tick_us_median=None)]
    runs += [
        result(seed=seed, method="dwa", goals_reached=20, makespan=None, robot_robot=2,
               wait_worst=0.0)
        for seed in range(2)
    ]  # fmt: skip
    waits = [COLUMNS["worst wait [s]"](row) for row in summarise(runs)]
    assert waits == ["5", "5", "-"]  # it does not count them
    runs += [
        result(
            scenario="circle", robots=40, seed=7, goals_sent=40, goals_reached=39, makespan=None,
            first_miss="Srobot3 missed home of Srobot23 at t = 600.0 s",
        )
    ]  # fmt: skip
    text = traffic_report(runs, "a machine", "swarm-bench report-traffic own.jsonl -o own.md")
    assert "a machine" in text
    assert "\n```\nswarm-bench report-traffic own.jsonl -o own.md\n```\n" in text
    assert "swarm-bench suite" not in text
    assert "collisions (robots + environment)" in text
    assert (
        "|slim_blockage|20|3|0+0|480/480|601 [600..602]|601 [600..602]"
        "|≤ 650, stretch 450: met" in text
    )
    assert "|slim_blockage|20|1|0+0|160/160|640 [640..640]" in text  # on the graph
    assert "|slim_blockage|20|2|12 %, 4 contacts, -|100 %, 0 contacts" in text
    assert "|circle|40|1|0+0|39/40|-|-|≤ 125: missed|" in text
    assert "Srobot3 missed home of Srobot23" in text


def test_the_suite_covers_every_scenario_and_method():
    ours, dwa, orca, ros = suite_sweeps("suite", "0-2", "0-2", 50, None, LocalExecutor())
    assert len([item for item in ours.items if item.scenario.name == "crossing"]) == 1000
    assert len([item for item in ours.items if item.robots == 100]) == 5
    assert {item.method for item in (*dwa.items, *orca.items)} == {"dwa", "orca"}
    assert ros.runner is run_on_graph
    assert max(item.robots for item in ros.items) == 50
    assert all(item.scenario.with_lidar for item in ros.items)
    first = [item for item in ours.items if item.seed == 0]
    assert list(ours.items[: len(first)]) == first
    assert first[0].robots == 100
    assert len(suite_sweeps("0", "none", "none", 50, None, LocalExecutor())) == 1


def test_a_run_on_the_graph_gets_all_that_the_scenario_says(tmp_path):
    (options,) = select("dead_robot", [4], [2], engine="bullet", loss=0.1)
    spec = spec_of(options, tmp_path)
    assert (spec.world, spec.swarm_size, spec.seed) == ("slim_blockage", 4, 2)
    text = (tmp_path / "params.yaml").read_text(encoding="utf-8")
    assert "radio.loss: 0.1" in text
    assert "actuation_noise: 0.02" in text
    assert "broken.Srobot4" in text
    (mixed,) = select("mixed_fleet", [5], [0], engine="bullet")
    assert spec_of(mixed, tmp_path).size == 5
    (people,) = select("walkers", [5], [0], engine="bullet")
    spec_of(people, tmp_path)
    assert "people.yaml" in (tmp_path / "params.yaml").read_text(encoding="utf-8")


def test_a_report_becomes_a_result():
    (options,) = select("slim_blockage", [2], [0], engine="bullet", lidar=True)
    report = json.loads((Path(__file__).parent / "report.json").read_text(encoding="utf-8"))
    found = result_of_report(options, report)
    assert (found.engine, found.goals_sent, found.goals_reached) == ("ros", 16, 15)
    assert found.makespan is None  # a goal is missing
    assert found.first_collision.startswith("collision of Srobot1 and Srobot2 at (1.00, 2.00)")
    assert found.first_miss.startswith("Srobot2 did not get to home")
    assert found.per_robot["Srobot1"].goals_reached == 8


def test_a_document_names_the_files_that_it_was_made_from(tmp_path, monkeypatch):
    add_lines(tmp_path / "own.jsonl", [result()])
    monkeypatch.chdir(tmp_path)
    words = ["report-traffic", "own.jsonl", "-o", "own.md", "--machine", "mine"]
    monkeypatch.setattr("sys.argv", ["swarm-bench", *words])
    bench_app(words, standalone_mode=False)
    bench_app(words, standalone_mode=False)  # into the document that is there now
    text = (tmp_path / "own.md").read_text(encoding="utf-8")
    assert text.count("<!-- suite -->") == 1
    assert "\nswarm-bench report-traffic own.jsonl -o own.md --machine mine\n" in text
    assert "swarm-bench suite" not in text


def test_a_document_without_the_part_is_left_alone(tmp_path):
    add_lines(tmp_path / "own.jsonl", [result()])
    own = tmp_path / "own.md"
    own.write_text("# Mine\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="has no part 'suite'"):
        bench_app(
            ["report-traffic", str(tmp_path / "own.jsonl"), "-o", str(own)], standalone_mode=False
        )
    assert own.read_text(encoding="utf-8") == "# Mine\n"


def test_a_mean_has_an_interval_if_there_are_several_runs():
    (row,) = summarise([result(seed=k, makespan=100.0 + 10.0 * (k % 2)) for k in range(20)])
    assert row.mean_text == "105 [103..107]"
    assert row.wait_ratio == 5.0
    (alone,) = summarise([result(makespan=100.0, wait_median=0.0)])
    assert (alone.mean_text, alone.wait_ratio) == ("100", None)


@pytest.mark.parametrize(
    "words", [["halls", "--seeds", "0"], ["suite", "--json", "own.jsonl", "--ros-seeds", "none"]]
)
def test_a_part_that_is_missing_is_told_before_anything_runs(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.md").write_text("# Mine\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="has no part"):
        _load()([*words, "-o", "own.md"], standalone_mode=False)
    assert not (tmp_path / "own.jsonl").exists()

"""The same plug-ins drive the same way in the bench and on the ROS graph."""

import dataclasses
from pathlib import Path

import yaml

from swarm_bench.runs.episode import RunOptions, parameter_sections
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.ros_run import run_on_graph
from swarm_bench.runs.scenario import load_scenario
from tests.fakes.policies import save_policy

ROOT = Path(__file__).parents[2]
HERE = "tests.fakes.plugins:"
FILE = {
    "/**": {
        "planner.plugin": HERE + "Dijkstra",
        "traffic.priority_plugin": HERE + "HighestId",
        "localiser.plugin": HERE + "DeadReckoning",
    },
    "/Srobot2/navigator": {"controller.plugin": HERE + "Pursuit"},
}


def test_bench_and_graph_are_equal(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    path = tmp_path / "params.yaml"
    tree = {name: {"ros__parameters": values} for name, values in FILE.items()}
    path.write_text(yaml.safe_dump(tree), "utf-8")
    scenario = load_scenario("circle")
    sections = parameter_sections(path, 3)
    options = RunOptions(scenario=scenario, robots=3, sections=sections)
    bench = Harness(options).run()
    graph = run_on_graph(options)
    usual = Harness(RunOptions(scenario=scenario, robots=3)).run()
    assert bench.is_flawless
    assert bench.trajectory_sha256 == graph.trajectory_sha256 != usual.trajectory_sha256
    assert graph.conditions["/Srobot2/navigator controller.plugin"] == HERE + "Pursuit"


def test_a_policy_drives_the_same_way_on_bench_and_graph(tmp_path):
    path = save_policy(tmp_path / "policy.onnx")
    scenario = dataclasses.replace(load_scenario("circle"), time_limit={3: 12.0}, with_lidar=True)
    options = RunOptions(scenario=scenario, robots=3, method=path)
    bench = Harness(options).run()
    parameters = {"brain.plugin": path}
    graph = run_on_graph(dataclasses.replace(options, method="ours", parameters=parameters))
    usual = Harness(dataclasses.replace(options, method="ours")).run()
    assert bench.trajectory_sha256 == graph.trajectory_sha256 != usual.trajectory_sha256

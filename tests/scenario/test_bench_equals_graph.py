"""The bench and the ROS graph are the same swarm: equal seeds give equal trajectories."""

import pytest

from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.scenario import load_scenario
from swarm_run.record.report_file import record_of
from swarm_run.record.run_record import RobotRecord, RunRecord

MISSION = """
route:
  - {stations: [loader_1]}
"""  # one station for all: they hold, and push who has finished out of the way
SCENARIO = """
world: slim_blockage
mission: MISSION
robots: [3]
with_lidar: true
loss: 0.2
delay: 0.1
noise: 0.02
"""
PARAMS = """
/world:
  ros__parameters:
    radio: {loss: 0.2, delay: 0.1}
    actuation_noise: 0.02
"""


NAMES = {"scenario", "method", "engine", "conditions", "processes"}
OF_CLOCK = {"wall_time", "cpu_ms_per_robot_second", "tick_us_median", "tick_us_p99"}
OF_BENCH = {"min_held_gap", "min_held_slack", "least_held_slack", "ground_truth"}
# of status messages, which come when the clock on the wall says so
SAMPLED = {
    "hold_time", "wait_time", "wait_median", "wait_worst", "waits", "wait_circles",
    "longest_wait_circle",
}  # fmt: skip
NOT_COMPARED = NAMES | OF_CLOCK | OF_BENCH | SAMPLED


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_bench_and_graph_give_equal_trajectories_and_records(start, tmp_path):
    (tmp_path / "short.yaml").write_text(MISSION, encoding="utf-8")
    (tmp_path / "params.yaml").write_text(PARAMS, encoding="utf-8")
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(SCENARIO.replace("MISSION", str(tmp_path / "short.yaml")), "utf-8")
    options = RunOptions(scenario=load_scenario(str(scenario)), robots=3, seed=3, engine="bullet")
    result = Harness(options).run()
    swarm = start(
        "--swarm-size", "3", "--seed", "3", "--mission", str(tmp_path / "short.yaml"),
        "--params", str(tmp_path / "params.yaml"), "--until-done", "--headless", "--speed", "max",
    )  # fmt: skip
    found = record_of(swarm.good_report(240.0))
    assert result.is_flawless
    assert result.pushes
    for name in set(RunRecord.__struct_fields__) - NOT_COMPARED - {"per_robot"}:
        told, counted = getattr(found, name), getattr(result, name)
        is_number = isinstance(counted, float)
        assert told == (pytest.approx(counted, abs=1e-4) if is_number else counted), name
    for robot, other in result.per_robot.items():
        for name in set(RobotRecord.__struct_fields__) - NOT_COMPARED:
            told, counted = getattr(found.per_robot[robot], name), getattr(other, name)
            assert told == pytest.approx(counted, abs=1e-4), (robot, name)

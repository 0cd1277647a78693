"""What a decision costs, by the number of neighbours."""

from benchmarks.decisions import measure_decisions
from swarm_bench.runs.episode import RunOptions
from swarm_bench.runs.scenario import load_scenario


def test_every_decision_is_counted_with_its_neighbours():
    options = RunOptions(scenario=load_scenario("circle"), robots=12)
    rows = measure_decisions(options, 5)
    assert sum(row.count for row in rows) == 12 * 5
    assert all(row.least % 10 == 0 and row.least < 12 for row in rows)
    assert all(0.0 < row.median <= row.percentile_99 for row in rows)

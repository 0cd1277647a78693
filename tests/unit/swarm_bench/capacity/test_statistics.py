"""Intervals against published values, knees against curves whose knee is known, sentences."""

import json
from typing import Any

import msgspec
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_bench.capacity.curve import curve_of
from swarm_bench.capacity.findings import comparison_sentences, knee_sentence, reason_sentence
from swarm_bench.capacity.knee import find_knee
from swarm_bench.capacity.report import points_table, sentences, write_output
from swarm_bench.statistics import Interval, mean_of_runs
from swarm_run.record.figures import steady_of
from swarm_run.record.run_record import GroundTruth, StationShare
from tests.fakes.results import result


def test_batches_cover_the_throughput_of_a_queue():
    """M/M/1 with 36 arrivals and 60 services per hour: 95 of 100 intervals hold 36 per hour."""
    random = np.random.default_rng(1)
    held = 0
    for _ in range(200):
        arrivals = np.cumsum(random.exponential(100.0, 900))
        leaves = np.zeros(900)
        for number, service in enumerate(random.exponential(60.0, 900)):
            leaves[number] = max(arrivals[number], leaves[number - 1]) + service
        leads = leaves - arrivals
        run = steady_of(list(zip(leaves, leads, strict=True)), 10_000.0, 80_000.0)
        per_batch = [360.0 / 7000.0 * 10.0 * count for count in run.finished]
        found = mean_of_runs([run.per_hour], [per_batch])
        held += found.low <= 36.0 <= found.high
    assert 180 <= held <= 200
    assert sum(run.finished) == round(run.per_hour * 70_000.0 / 3600.0)


def around(value, error):
    return Interval(value, value - 2.262 * error, value + 2.262 * error, 9)


@settings(max_examples=25, deadline=None)
@given(
    knee=st.integers(12, 40),
    slope=st.floats(5.0, 50.0),
    after=st.floats(-0.5, 0.2),
    noise=st.floats(0.0, 0.01),
)
def test_a_knee_is_found_within_its_interval(knee, slope, after, noise):
    sizes = list(range(4, 61, 4))
    values = [slope * (min(n, knee) + after * max(n - knee, 0)) for n in sizes]
    points = [around(value, noise * slope * knee) for value in values]
    found = find_knee(sizes, points)
    assert abs(found.robots - knee) <= 1
    assert found.low <= knee + 1
    assert found.high >= knee - 1


def test_a_straight_line_has_no_knee_and_a_mean_is_after_the_warm_up():
    sizes = [4, 8, 12, 16, 20]
    assert find_knee(sizes, [around(10.0 * n, 3.0) for n in sizes]) is None
    noisy = [around(10.0 * min(n, 12), 90.0) for n in sizes]
    assert find_knee(sizes, noisy) is None  # not certain
    assert find_knee(sizes[:3], noisy[:3]) is None
    run = steady_of([(5.0, 5.0), (15.0, 4.0), (30.0, 8.0), (999.0, 1.0)], 10.0, 110.0)
    assert run.finished == (1, 0, 1, *[0] * 7)
    assert (run.per_hour, run.lead_time) == (72.0, 6.0)


def run_of(robots, seed, finished, share, name="dock"):
    """Return a run with a station in use for a share of the time."""
    truth = GroundTruth(
        stood_time=0.0, stood_worst=0.0, stood_share=0.5 if name == "" else 0.0, circles=0,
        longest_circle=0.0, deadlocks=0,
        stations={"gate": StationShare(occupied=0.1, approached=0.3)}
        | ({name: StationShare(occupied=share, approached=share)} if name else {}),
    )  # fmt: skip
    ends = [(10.0 + (k + 0.5) * 3600.0 / finished, 30.0) for k in range(finished)]
    fields: dict[str, Any] = {"robots": robots, "seed": seed, "ground_truth": truth}
    return result(**fields, steady=steady_of(ends, 10.0, 3610.0))


def hinged(label, names, share=0.96, extra=0):
    """Return a curve with its knee at 20 robots; `names` are the full stations by seed."""
    runs = [
        run_of(n, seed, 10 * min(n, 20) + seed + extra, share if n >= 16 else 0.4, names[seed])
        for n in range(4, 41, 4)
        for seed in range(len(names))
    ]
    return curve_of(label, runs)


def test_a_reason_is_told_only_if_it_holds_in_every_run():
    agreed = hinged("", ["dock"] * 4)
    assert knee_sentence(agreed).startswith("Up to 20 robots [")
    assert reason_sentence(agreed) == (
        "From 20 robots on dock is occupied or approached 96 % [96, 96] of the time."
    )
    assert reason_sentence(hinged("", ["dock", "dock", "ramp", "dock"])) == ""
    assert reason_sentence(hinged("", ["dock"] * 4, share=0.6)) == ""
    assert reason_sentence(hinged("", ["dock"] * 2)) == ""  # two seeds are no agreement
    assert "the floor is full" in reason_sentence(hinged("", [""] * 4))


def test_two_variants_are_compared_on_the_same_seeds():
    told = comparison_sentences(hinged("a", ["dock"] * 4), hinged("b", ["dock"] * 4, extra=9))
    assert told[0] == (
        "With 4 robots b finishes more: +9.0 goals per hour [+9.0, +9.0], +21.7 % (4 seeds)."
    )
    same = comparison_sentences(hinged("a", ["dock"] * 4), hinged("b", ["dock"] * 4))
    assert "both finish the same" in same[0]


def test_a_swarm_that_orders_overrun_does_not_look_steady(tmp_path):
    """An order each 60 s, done 50 s after the one before, or in 100 s: the second backlog grows."""
    runs = []
    for robots, takes in ((4, 100.0), (8, 50.0)):
        times = [(60.0 * k, max(60.0, takes) * k + takes) for k in range(30)]
        done = [(end, end - begin) for begin, end in times if end <= 1800.0]
        orders = [{"created": a, "done": b if b <= 1800.0 else None} for a, b in times]
        steady = steady_of(done, 600.0, 1800.0, "orders")
        truth = GroundTruth(
            stood_time=0.0, stood_worst=0.0, stood_share=0.0, circles=0, longest_circle=0.0,
            deadlocks=0, stations={},
        )  # fmt: skip
        runs += [
            result(robots=robots, seed=seed, orders={"orders": orders}, steady=steady,
                   ground_truth=msgspec.structs.replace(truth, stood_share=0.1 * (seed > 1)))
            for seed in range(3)
        ]  # fmt: skip
    curve = curve_of("", runs)
    path = tmp_path / "a.json"
    write_output(path, [curve], sentences([curve], compare=False), "")
    summary = json.loads(path.read_text(encoding="utf-8"))
    assert summary["sentences"][0].endswith(
        "Demand not met: open orders, and lead times with them, grow with 4 (5 to 12) robots."
    )
    overrun, steady = summary["variants"][0]["points"]
    assert [point["demand_met"] for point in (overrun, steady)] == [False, True]
    assert overrun["lead_time_low"] is None
    assert steady["throughput"] == 60.0
    assert steady["throughput_low"] is None
    assert steady["stood_low"] == 0.0
    assert points_table([curve]).rows[0][6:8] == ["5 to 12", "no"]

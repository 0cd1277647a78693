"""Rollouts and the choice of the dynamic window against their slow twins."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from swarm_nav.control import dwa_kernels as kernels
from swarm_nav.core.config import ControllerConfig
from swarm_nav.planning.distance_kernels import Place
from tests.oracles import control as oracle

DEFAULT = ControllerConfig()
STEPS = 8
LIMITS = kernels.Limits(0.26, 1.82, 1.0, 3.2)
SCALES = kernels.Scales(
    DEFAULT.path_distance_scale,
    DEFAULT.goal_distance_scale,
    DEFAULT.path_align_scale,
    DEFAULT.oscillation_scale,
)
EAST = np.column_stack((np.arange(0.0, 0.65, 0.05), np.zeros(13)))


def bend(radius, count=13):
    angle = 0.05 / radius * np.arange(count)
    return np.column_stack((radius * np.sin(angle), radius * (1.0 - np.cos(angle))))


def segments_of(path):
    segments = np.empty((len(path), 6))
    kernels.measure(path, segments)
    return segments


@settings(max_examples=50, deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(0.0, 0.3), st.floats(-1.8, 1.8))
def test_a_rollout_follows_the_constant_twist(yaw, v, w):
    out, track, headings = np.empty((STEPS, 3)), np.empty((STEPS, 3)), np.empty((STEPS, 2))
    kernels.predict(Place(0.1, -0.2, yaw), v, w, out)
    expected = oracle.arc((0.1, -0.2, yaw), v, w, STEPS, kernels.STEP)
    assert np.allclose(out, expected)
    assert kernels.turning(yaw, w, headings) == pytest.approx(expected[-1, 2])
    kernels.advance(Place(0.1, -0.2, yaw), v * kernels.STEP, headings, EAST, track)
    assert np.allclose(track[:, :2], expected[:, :2])


@settings(max_examples=30, deadline=None)
@given(st.floats(-0.1, 0.7), st.floats(-0.3, 0.5))
def test_the_gap_to_a_path_is_that_of_the_segments_beside_its_nearest_point(x, y):
    path = bend(0.6)
    nearest = int(np.hypot(*(path - (x, y)).T).argmin())
    gap = math.sqrt(kernels.segment_gap(path, segments_of(path), nearest, x, y))
    assert gap == pytest.approx(oracle.segment_gap(path, x, y), abs=1e-3)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 12), st.floats(-0.3, 0.9), st.floats(-0.5, 0.5))
def test_the_held_gap_is_that_to_the_held_segments(held, x, y):
    path = bend(0.6)
    gap = kernels.held_gap(path, held, x, y)
    assert gap == pytest.approx(oracle.held_gap(path, held, x, y), abs=1e-3)


def test_points_in_one_place_have_the_gap_of_that_place():
    assert kernels.held_gap(np.zeros((3, 2)), 2, 0.3, 0.4) == pytest.approx(0.5)


@settings(max_examples=60, deadline=None)
@given(
    st.tuples(st.floats(-0.1, 0.5), st.floats(-0.1, 0.2), st.floats(-math.pi, math.pi)),
    st.floats(0.0, 0.26), st.floats(0.0, 0.26), st.floats(-1.82, 1.82), st.integers(0, 12),
    st.floats(0.0, 0.3),
)  # fmt: skip
def test_a_twist_stops_inside_where_braking_ends_near_the_held_part(pose, speed, v, w, held, reach):
    path = bend(0.6)
    stop = oracle.stop_point(pose, speed, v, w, 1.0, kernels.STEP)
    gap = oracle.held_gap(path, held, *stop)
    assume(abs(gap - reach) > 1e-3)
    assert kernels.stops_inside(Place(*pose), speed, v, w, 1.0, path, held, reach) == (gap < reach)


def test_the_score_of_a_rollout_is_its_mean_squared_gap():
    headings, track = np.empty((STEPS, 2)), np.empty((STEPS, 3))
    kernels.turning(0.0, 0.0, headings)
    reached = kernels.advance(Place(0.0, 0.1, 0.0), 0.2 * kernels.STEP, headings, EAST, track)
    assert reached == 3  # 0.16 m along
    unit = kernels.DISTANCE_UNIT**2
    cost = kernels.gap_cost(track, EAST, segments_of(EAST), 32.0, 1e20)
    assert cost == pytest.approx(32.0 * 0.01 / unit)
    assert kernels.gap_cost(track, EAST, segments_of(EAST), 32.0, 0.9 * cost) == 1e20
    assert kernels.gap_cost(track, EAST, segments_of(EAST), 0.0, 0.0) == 0.0


def best(path, v=0.2, w=0.0, v_limit=1.0, yaw=0.0):
    arc = np.empty((STEPS, 3))
    v, w, _ = kernels.best_twist(
        Place(0.0, 0.0, yaw), kernels.Velocity(v, w), path,
        kernels.StopConstraint(v_limit, len(path) - 1, 0.035), LIMITS,
        kernels.Samples(DEFAULT.vx_samples, DEFAULT.vtheta_samples, DEFAULT.sim_time), SCALES, arc,
    )  # fmt: skip
    return v, w, arc


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.0, 0.26), st.floats(-1.8, 1.8), st.floats(0.0, 0.4), st.floats(-0.3, 0.3),
    st.floats(0.4, 5.0),
)  # fmt: skip
def test_the_chosen_twist_lies_in_the_dynamic_window(v, w, v_limit, yaw, radius):
    chosen_v, chosen_w, _ = best(bend(radius), v, w, v_limit, yaw)
    slack = 1e-9
    assert max(0.0, v - 0.1) - slack <= chosen_v <= min(0.26, v + 0.1) + slack
    assert chosen_v <= max(v_limit, v - 0.1) + slack
    assert abs(chosen_w - w) <= 0.32 + slack
    assert abs(chosen_w) <= 1.82 + slack


@pytest.mark.parametrize("rate", [1.5, -1.5, 0.2])
def test_without_an_admissible_twist_the_robot_brakes_within_its_window(rate):
    held = np.ascontiguousarray(EAST + np.array((0.05, 0.0)))
    v, w, _ = best(held, 0.2, rate, yaw=math.pi)  # driving away from it
    assert v == pytest.approx(0.1)
    assert w == pytest.approx(math.copysign(max(0.0, abs(rate) - 0.32), rate))


def test_straight_ahead_is_full_speed_and_lengths_go_on_beyond_ends():
    v, w, arc = best(EAST)
    assert v == pytest.approx(0.26)
    assert w == 0.0
    assert np.allclose(arc, oracle.arc((0.0, 0.0, 0.0), v, w, STEPS, kernels.STEP))
    _, w, _ = best(np.ascontiguousarray(EAST + np.array((0.0, 0.06))))
    assert w > 0.05
    segments = segments_of(EAST)
    assert kernels.arc_length(EAST, segments, 0, -0.02, 0.0) == pytest.approx(-0.02)
    assert kernels.arc_length(EAST, segments, 4, 0.22, 0.03) == pytest.approx(0.22)
    assert kernels.arc_length(EAST, segments, 12, 0.63, 0.0) == pytest.approx(0.63)


@pytest.mark.parametrize("side", [1, -1])
def test_a_bend_is_followed_to_its_side(side):
    path = bend(0.5) * (1, side)
    _, w, _ = best(np.ascontiguousarray(path), w=0.3 * side)
    assert side * w > 0.2


@settings(max_examples=100, deadline=None)
@given(
    st.tuples(st.floats(-0.05, 0.1), st.floats(-0.1, 0.1), st.floats(-0.5, 0.5)),
    st.floats(0.0, 0.26), st.floats(-1.8, 1.8), st.floats(0.0, 0.4), st.integers(0, 12),
    st.floats(0.3, 5.0), st.tuples(st.integers(2, 9), st.integers(2, 21)),
)  # fmt: skip
def test_the_chosen_twist_is_the_best_of_all_samples(
    pose, v, w, v_limit, held,
    radius, samples,
):  # fmt: skip
    path = bend(radius)
    arc = np.empty((STEPS, 3))
    inside = kernels.StopConstraint(v_limit, held, 0.035)
    chosen = kernels.best_twist(
        Place(*pose),
        kernels.Velocity(v, w),
        path,
        inside,
        LIMITS,
        kernels.Samples(*samples, DEFAULT.sim_time),
        SCALES,
        arc,
    )
    costs = oracle.twist_costs(
        pose, (v, w), path, v_limit, LIMITS, samples, DEFAULT.sim_time, SCALES, STEPS
    )
    gap = kernels.held_gap(path, held, *pose[:2])
    slowest = min(twist[0] for twist in costs)
    admissible = {
        twist: cost
        for twist, cost in costs.items()
        if kernels.stops_inside(
            Place(*pose),
            v,
            *twist,
            LIMITS[2],
            path,
            held,
            max(0.035, gap * (kernels.RETURN if twist[0] > slowest else 1.0)),
        )
    }
    if admissible:
        assert chosen[2] == pytest.approx(min(admissible.values()), rel=1e-9)
        assert admissible[chosen[:2]] == pytest.approx(chosen[2], rel=1e-9)
    else:
        assert chosen[2] == 1e20

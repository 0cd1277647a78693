import numpy as np
import pytest

from swarm_view.state.track import JUMP, Track, Trails


def poses(*rows):
    return np.array(rows, float).reshape(-1, 3)


def test_robots_glide_the_short_way_and_jump_elsewhere():
    track = Track()
    track.add(poses((0, 0, 0)), 0.0)
    for k in range(1, 30):
        track.add(poses((0.1 * k, 0, 0)), 0.1 * k)
    start, half, end = (track.at(2.9 + dt)[0, 0] for dt in (0.0, 0.05, 0.1))
    assert start == pytest.approx(2.8, abs=0.02)
    assert half == pytest.approx(0.5 * (start + end), abs=0.01)
    assert track.at(9.0)[0, 0] == pytest.approx(2.9)
    track = Track()
    track.add(poses((0, 0, 3.1)), 0.0)
    track.add(poses((0, 0, -3.1)), 0.1)
    assert abs(track.at(0.15)[0, 2]) > 3.1
    track = Track()
    track.add(poses((0, 0, 0), (0, 0, 0)), 0.0)
    track.add(poses((2 * JUMP, 0, 0), (0.1, 0, 0)), 0.1)
    shown = track.at(0.1)
    assert shown[0, 0] == 2 * JUMP
    assert shown[1, 0] < 0.1


def test_trails_are_polylines_without_jumps():
    trails = Trails(length=4, spacing=0.1)
    assert trails.segments().shape == (0, 2, 2)
    for x in (0.0, 0.05, 0.2, 0.4, 5.0, 5.2):
        trails.add(poses((x, 0, 0)))
    assert [tuple(s[:, 0]) for s in trails.segments()] == [(0.2, 0.4), (5.0, 5.2)]
    trails.clear()
    assert len(trails.segments()) == 0

"""The controller of long robots: it tracks the line of a slot, and is DWA elsewhere."""

import functools
import math

import numpy as np
import pytest

from swarm_common.model.records import Pose, Twist
from swarm_describe.robots.loading import load_robot
from swarm_nav.control.controller import MOST_RATE, Controller, StraightController
from swarm_nav.core.config import ControllerConfig, NavConfig
from swarm_nav.reservation.tube import Tube
from swarm_nav.traffic.robot_state import terrain_of
from tests.fakes.navigation import Unicycle, room

LINE = 2.55  # [m] y of the slot


@functools.cache
def slots():
    walls = (3.0, 0.0, 6.0, LINE - 0.45), (3.0, LINE + 0.45, 6.0, 5.0)
    found = terrain_of(NavConfig(), load_robot("carrier"), room(9.0, 5.0, *walls)).lattice.slots
    assert found is not None
    return found


def tube_through(x, length=1.5, held=None):
    """Return a tube along the line from x on, held as a whole or for some points."""
    tube = Tube(Pose(x, LINE, 0.0), 1, 0.35, 0.35)
    tube.slots = slots()
    ahead = np.arange(x, x + length, 0.05)
    tube.adopt(np.column_stack((ahead, np.full(len(ahead), LINE))))
    tube.stop = len(tube.points) - 1 if held is None else held
    return tube


def follow(pose, twist=None, held=None):
    tube = tube_through(3.6, held=held)
    tube.track(pose)
    return StraightController(ControllerConfig()).follow(tube, pose, twist or Twist(0.1))


def test_on_the_line_it_drives_without_turning_and_in_a_hall_as_usual():
    assert slots().is_slot(np.array(((3.6, LINE),))).all()
    twist = follow(Pose(3.6, LINE, 0.0))
    assert twist.vx > 0.1
    assert twist.wz == pytest.approx(0.0, abs=1e-9)
    pose, twist = Pose(1.0, LINE + 0.02, 0.1), Twist(0.1)
    tube = tube_through(1.0, 0.8)
    tube.track(pose)
    found = [
        kind(ControllerConfig()).follow(tube, pose, twist)
        for kind in (StraightController, Controller)
    ]
    assert found[0] == found[1]


@pytest.mark.parametrize("offset", [-0.03, 0.03])
def test_beside_the_line_it_turns_towards_it(offset):
    assert follow(Pose(3.6, LINE + offset, 0.0)).wz * offset < 0.0


@pytest.mark.parametrize("error", [-0.3, 0.3])
def test_a_wrong_heading_is_corrected_before_it_drives_on(error):
    twist = follow(Pose(3.6, LINE, error), Twist())
    assert twist.vx == 0.0
    assert -MOST_RATE <= twist.wz <= MOST_RATE
    assert twist.wz * error < 0.0


def test_it_comes_to_the_line_and_stops_at_the_end_of_what_is_held():
    controller, body = (
        StraightController(ControllerConfig()),
        Unicycle(Pose(3.6, LINE + 0.02, 0.02)),
    )
    tube = tube_through(3.6, held=20)
    for _ in range(150):
        tube.track(body.pose)
        body.step(controller.follow(tube, body.pose, body.twist))
        assert abs(body.pose.yaw) < 0.1
        assert body.pose.x < 4.6 + 0.04
    assert body.pose.x > 4.5
    assert abs(body.pose.y - LINE) < 0.01
    assert math.hypot(body.twist.vx, body.twist.wz) < 0.02

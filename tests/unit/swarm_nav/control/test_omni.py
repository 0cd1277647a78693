"""The controller of omnidirectional drives."""

import math

import numpy as np
import pytest

from swarm_common.model.records import Pose, Twist
from swarm_describe.robots.loading import load_robot
from swarm_nav.control.controller import TUBE_TOLERANCE, Controller
from swarm_nav.control.dwa_kernels import held_gap
from swarm_nav.control.omni import OmniController, make_controller
from swarm_nav.control.omni_kernels import PlanarLimits, PlanarVelocity, stop_gap
from swarm_nav.core.config import ControllerConfig
from swarm_nav.planning.distance_kernels import Place
from swarm_nav.reservation.tube import Tube

CONFIG = ControllerConfig(
    max_vel_x=0.4, max_vel_y=0.4, max_vel_theta=0.75, acc_lim_x=2.5, acc_lim_y=2.5
)
ROUTES = {
    "sideways": [(0.0, 0.05 * k) for k in range(30)],
    "backwards": [(-0.05 * k, 0.0) for k in range(30)],
    "corner": [(0.05 * k, 0.0) for k in range(12)] + [(0.55, 0.05 * k) for k in range(1, 16)],
    "circle": [(math.sin(0.1 * k), 1.0 - math.cos(0.1 * k)) for k in range(30)],
}


def move(pose, twist):
    """Drive for a control period, ramps left out."""
    middle = pose.yaw + 0.05 * twist.wz
    cos, sin = math.cos(middle), math.sin(middle)
    return Pose(
        pose.x + 0.1 * (cos * twist.vx - sin * twist.vy),
        pose.y + 0.1 * (sin * twist.vx + cos * twist.vy),
        pose.yaw + 0.1 * twist.wz,
    )


def ramped(now, wish):
    def ramp(a, b, most):
        return a + max(-most, min(most, b - a))

    return Twist(
        ramp(now.vx, wish.vx, 0.25), ramp(now.vy, wish.vy, 0.25), ramp(now.wz, wish.wz, 0.32)
    )


def test_the_drive_decides_and_nothing_moves_without_a_held_path():
    assert type(make_controller(load_robot("turtlebot3_waffle"), CONFIG)) is Controller
    assert type(make_controller(load_robot("linorobot2_4wd"), CONFIG)) is Controller
    assert type(make_controller(load_robot("linorobot2_mecanum"), CONFIG)) is OmniController
    controller = OmniController(CONFIG)
    assert controller.course(Twist(-0.3, 0.4, 0.1)) == Twist(0.5, 0.0, 0.1)
    assert Controller(CONFIG).course(Twist(-0.3, 0.0, 0.1)) == Twist(-0.3, 0.0, 0.1)
    controller = OmniController(CONFIG)
    pose = Pose(0.0, 0.0, 0.0)
    tube = Tube(pose, 1, 0.35, 0.35)
    tube.track(pose)
    assert controller.follow(tube, pose, controller.course(Twist())) == Twist()
    tube.adopt(np.array(ROUTES["sideways"]))
    tube.track(pose)
    twist = controller.follow(tube, pose, controller.course(Twist()))
    assert math.hypot(twist.vx, twist.vy) < 1e-6


@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_a_held_path_is_followed_to_its_end_without_leaving_it(route, yaw):
    controller = OmniController(CONFIG)
    pose, twist = Pose(0.0, 0.0, yaw), Twist()
    tube = Tube(pose, 1, 0.35, 0.35)
    tube.adopt(np.array(ROUTES[route]))
    tube.stop = len(tube.points) - 1
    worst = 0.0
    for _ in range(120):
        tube.track(pose)
        wish = controller.follow(tube, pose, controller.course(twist))
        assert math.hypot(wish.vx, wish.vy) <= 0.4 + 1e-9
        twist = ramped(twist, wish)
        pose = move(pose, twist)
        worst = max(worst, held_gap(tube.points, len(tube.points) - 1, pose.x, pose.y))
    assert worst <= TUBE_TOLERANCE + 0.01
    end = tube.points[-1]
    assert math.hypot(pose.x - end[0], pose.y - end[1]) < 0.05


def test_braking_ends_where_the_kernel_says():
    path = np.array([(0.0, 0.0), (0.0, 1e-9)])
    limits = PlanarLimits(0.4, 0.4, 0.75, 2.5, 2.0, 3.2)
    pose, now = Place(0.0, 0.0, 0.7), PlanarVelocity(0.2, -0.1, 0.0)
    gap = stop_gap(pose, now, 0.3, 0.1, 0.0, limits, path, 1)
    ahead = 0.1 * 0.25 + 0.3**2 / 5.0
    aside = 0.1 * 0.0 + 0.1**2 / 4.0
    assert gap == pytest.approx(math.hypot(ahead, aside))

"""A robot that was put elsewhere and does not answer: the tick waits for it, but not for long."""

import time

import rclpy
from rclpy.context import Context

from swarm_common.model.records import Pose
from swarm_sim.ros.robots.moves import LIMIT, Moves
from tests.fakes.ros_domains import reserved_domain

TICK_LIMIT = 1.0  # [s] of wall time that no request may cost a tick


def test_a_tick_does_not_wait_long_for_who_does_not_answer():
    with reserved_domain() as domain:
        context = Context()
        rclpy.init(context=context, domain_id=domain)
        node = rclpy.create_node("world", context=context, enable_rosout=False)
        moves = Moves(node)
        begun = time.monotonic()
        moves.tell(0, "Srobot1", Pose(1.0, 2.0, 0.0), 5, LIMIT, speaks=False)
        moves.settle(lambda: False)
        assert time.monotonic() - begun < TICK_LIMIT
        begun = time.monotonic()
        moves.settle(lambda: False)
        assert time.monotonic() - begun < 0.1 * TICK_LIMIT, "later ticks do not wait at all"
        moves.forget(0)
        node.destroy_node()
        context.try_shutdown()

"""A silent robot is a body, no more and no less: what is beside it is seen, it is remembered."""

import pytest

from swarm_common.model.beacon import reception_of
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind, Outcome
from swarm_sim.world.world import World, WorldConfig
from tests.fakes.navigation import room, waffle, without_lidar
from tests.fakes.traffic import hall_scene

ONE = 0  # index of the robot that lives


class Hall:
    """Robots in a hall with crates that no map shows."""

    def __init__(
        self, size, starts, crates = (),
        *, with_lidar,
    ):  # fmt: skip
        count = len(starts)
        config = NavConfig() if with_lidar else without_lidar()
        self.world = World(
            hall_scene(*size, tuple(crates)), [waffle()] * count, starts,
            WorldConfig(engine="planar", with_lidar=with_lidar), 1,
        )  # fmt: skip
        self.robots = [
            Navigator(config, waffle(), room(*size), Sites(), number, start)
            for number, start in enumerate(starts, 1)
        ]
        self.reached = [0] * count

    def run(self, ticks, dead=(), until=99):
        """Go on until the first robot has reached `until` goals; return whether it has."""
        for _ in range(ticks):
            outputs = [
                None if index in dead else self._live(robot, seen)
                for index, (robot, seen) in enumerate(
                    zip(self.robots, self.world.observe(), strict=True)
                )
            ]
            for index, output in enumerate(outputs):
                for event in output.events if output is not None else ():
                    if isinstance(event, GoalEnded):
                        self.reached[index] += event.outcome is Outcome.SUCCEEDED
            self.world.step(
                [o and o.twist for o in outputs], [o.beacon if o else None for o in outputs]
            )
            if self.reached[ONE] >= until:
                return True
        return False

    def _live(self, robot, seen):
        robot.on_odom(seen.odom)
        robot.on_reception(reception_of(seen.neighbors))
        if seen.scan is not None:
            robot.on_scan(seen.scan)
        return robot.tick(self.world.tick)

    def send(self, index, x, y):
        goal = Goal(kind=GoalKind.NAVIGATE, poses_map=(Pose(x, y, 0.0),))
        self.robots[index].set_goal(goal)


@pytest.mark.parametrize("silence", [5, 30, 60, 150])
def test_a_crate_beside_a_silent_robot_is_seen(silence):
    crate = (3.85, 3.85, 4.15, 4.15)
    starts = [Pose(1.0, 4.0, 0.0), Pose(4.0, 4.8, 0.0)]
    hall = Hall((8.0, 8.0), starts, [crate], with_lidar=True)
    hall.send(ONE, 7.0, 4.0)
    assert hall.run(900, until=1)
    hall.run(silence, dead=[1])
    hall.send(ONE, 1.0, 4.0)
    assert hall.run(900, dead=[1], until=2)
    assert hall.world.collisions == []


@pytest.mark.parametrize("gap", [4.0, 4.4, 5.2, 5.9])
def test_a_robot_that_dies_anywhere_in_range_is_remembered_without_lidar(gap):
    starts = [Pose(1.0, 1.15, 0.0), Pose(1.0 + gap, 1.15, 0.0)]  # on the lane of the first
    hall = Hall((10.0, 3.0), starts, with_lidar=False)
    hall.run(30)
    hall.run(40, dead=[1])
    hall.send(ONE, 9.0, 1.15)
    assert hall.run(1500, dead=[1], until=1)
    assert hall.world.collisions == []


def test_a_robot_that_left_is_no_obstacle_where_it_was_last_heard():
    """In an aisle for one robot, where nobody else tells that it lives."""
    starts = [Pose(1.0, 0.5, 0.0), Pose(5.5, 0.5, 0.0), Pose(9.5, 0.5, 0.0)]
    hall = Hall((20.0, 1.0), starts, with_lidar=False)
    hall.run(30)
    hall.send(2, 11.0, 0.5)
    hall.run(100)
    hall.send(1, 9.0, 0.5)
    hall.run(250)
    hall.send(2, 18.5, 0.5)
    hall.run(50)
    hall.send(1, 16.0, 0.5)
    hall.send(ONE, 12.0, 0.5)
    assert hall.run(1300, until=1)
    assert hall.world.collisions == []

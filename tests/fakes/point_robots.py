"""Robots without bodies: they drive straight at a constant speed through everything."""

import math
from collections.abc import Iterable, Mapping
from functools import partial

from swarm_common.model.records import CONTROL_PERIOD, Pose
from swarm_mission.itinerary import NextGoal
from swarm_mission.orders.messages import Envelope
from swarm_mission.orders.order import OrderPlan
from swarm_mission.orders.order_run import OrderRun
from swarm_mission.orders.radio import OrderRadio
from swarm_mission.orders.robot_bidder import BidSenses


class PointRobot:
    def __init__(self, home: Pose, speed: float) -> None:
        self.x, self.y, self.speed = home.x, home.y, speed
        self.goal: NextGoal | None = None

    def move(self, tick: int) -> bool:
        """Drive for a tick that has begun; return whether the goal is reached at its end."""
        goal = self.goal
        if goal is None or tick < goal.start_tick:
            return False
        pose, step = goal.stop.pose_map, self.speed * CONTROL_PERIOD
        way = math.hypot(pose.x - self.x, pose.y - self.y)
        if way <= step + 1e-9:
            self.x, self.y, self.goal = pose.x, pose.y, None
            return True
        self.x += (pose.x - self.x) * step / way
        self.y += (pose.y - self.y) * step / way
        return False

    def way_to(self, stations: Mapping[str, Pose], name: str) -> float:
        return math.hypot(stations[name].x - self.x, stations[name].y - self.y)


class MutingRadio(OrderRadio):
    """A radio over which some are not heard."""

    def __init__(self, loss: float, delay: float, seed: int) -> None:
        super().__init__(loss, delay, seed)
        self.mute: set[str] = set()

    def send(self, tick: int, envelopes: Iterable[Envelope]) -> None:
        super().send(tick, [each for each in envelopes if each.sender not in self.mute])


class PointSwarm:
    """A run of orders with such robots; time passes in `advance`."""

    def __init__(
        self,
        plan: OrderPlan,
        stations: dict[str, Pose],
        homes: dict[str, Pose],
        *,
        seed: int = 0,
        speed: float = 0.5,
        loss: float = 0.0,
        delay: float = 0.0,
    ) -> None:
        self.radio = MutingRadio(loss, delay, seed)
        self.run = OrderRun(plan, homes, stations, self.radio, seed)
        self.robots = {name: PointRobot(home, speed) for name, home in homes.items()}
        self.senses = {
            name: BidSenses(partial(robot.way_to, stations), speed)
            for name, robot in self.robots.items()
        }
        self.dead: set[str] = set()
        self.tick = 0

    def advance(self) -> None:
        for name, robot in self.robots.items():
            if name not in self.dead and robot.move(self.tick - 1):
                goal = self.run.couriers[name].on_end(True, self.tick)
                robot.goal = goal or robot.goal
        for name, goal in self.run.step(self.tick, self.senses, self.dead).items():
            self.robots[name].goal = goal
        for name, robot in self.robots.items():
            if name not in self.dead:
                share = self.run.couriers[name].share
                self.run.floor.note(self.tick, name, robot.x, robot.y, share)
        self.tick += 1

    def run_until(self, ticks: int) -> None:
        while self.tick < ticks and not self.run.is_over:
            self.advance()

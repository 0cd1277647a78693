"""The node /central: `python -m swarm_central.process CONFIG.json`; started by swarm-up."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import Any

from rclpy.publisher import Publisher

from swarm_central.config import central_from_texts
from swarm_central.link import Centre, delay_ticks
from swarm_central.reservation import MOST_COMMANDS, ReservationCentre
from swarm_central.team import RobotReport
from swarm_common.files.map_io import load_map
from swarm_common.middleware import central_io, ros_env, ros_io
from swarm_common.middleware.rclpy_compat import SafeExecutor, join_graph
from swarm_common.middleware.rejections import Rejections
from swarm_common.model.central import unpack_report
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.process.messages import (
    MISSION,
    Alive,
    CentreReported,
    Ready,
    RobotDead,
    RobotGone,
    RobotSilent,
)
from swarm_common.process.pipes import EventWriter, StartedProcess, leave
from swarm_describe.robots.loading import load_robot
from swarm_nav.ros.settings import read_node_settings

TURN_PERIOD = 0.05  # [s] of wall time between two looks at the pipe
FIGURES_PERIOD = 0.5  # [s] of wall time
MEETING = 30.0  # [s] of wall time that robots have to find the centre, before it goes on without


class CentralNode:
    """Receives the robots' reports, lets the team decide once they are all there, sends its orders.

    Attributes:
        refusal: Why the centre cannot decide; empty while it can.
    """

    def __init__(self, config: Mapping[str, Any], events: EventWriter) -> None:
        """Attach to the robots.

        Args:
            config: Configuration from `RunPlan.central_config`.
        """
        self.refusal = ""
        self._events = events
        self._numbers: dict[str, int] = config["robots"]
        self.executor = SafeExecutor()
        self._node = join_graph(central_io.CENTRE[1:])
        self._rejections = Rejections(events, self._node.get_logger().warning)
        self._team = _team(config)
        radio = config["radio"]
        delay = delay_ticks(radio["delay"])
        self._centre = Centre(
            self._team, len(config["models"]), radio["loss"], delay, seed=config["seed"]
        )
        self._team.rehearse()
        self._tick = self._decided = -1
        self._reports: dict[int, RobotReport] = {}  # of the present tick, by robot
        self._said: dict[int, bytes] = {}  # in the tick that was decided last, by robot
        self._awaited = set(self._numbers.values())  # robots that report each tick
        self._orders: dict[int, Publisher] = {}
        for name, number in self._numbers.items():
            self._orders[number] = self._node.create_publisher(
                central_io.KIND, f"/{name}/{central_io.ORDERS}", ros_io.RELIABLE
            )
            self._node.create_subscription(
                central_io.KIND,
                f"/{name}/{central_io.REPORT}",
                partial(self._receive, number),
                ros_io.TICK_INPUT,
                raw=True,
            )
        self.executor.add_node(self._node)
        self._is_met = False  # whether it and its robots hear each other
        self._meets_until = time.monotonic() + MEETING

    def _receive(self, number: int, data: bytes) -> None:
        try:
            report = unpack_report(central_io.unwrapped(data))
            if report.robot_id != number:
                raise ValueError(f"a report of robot {report.robot_id} on the topic of {number}")
        except ValueError as error:
            self._rejections.reject(central_io.REPORT, f"robot {number}", error)
            return
        self._awaited.add(number)
        if report.tick <= self._decided:
            if report.tick == self._decided and number in self._said:
                self._orders[number].publish(self._said[number])
            return
        if report.tick > self._tick:
            self._awaited &= {number, *self._reports} if self._reports else self._awaited
            self._decide()
            self._tick = report.tick
        self._reports[number] = report
        self._decide_if_all()

    def _decide_if_all(self) -> None:
        if self._reports and self._awaited <= self._reports.keys():
            self._decide()

    def _decide(self) -> None:
        """Decide on what has been heard of the present tick, and speak to all who have reported."""
        if not self._reports or self.refusal:
            return
        reports, self._reports = self._reports, {}
        self._decided = self._tick
        orders: dict[int, list[bytes]] = {number: [] for number in reports}
        try:
            decided = self._centre.step(self._tick, [reports[number] for number in sorted(reports)])
        except ConfigError as error:  # an external solver's: nothing else plans in its name
            self.refusal = str(error)
            return
        for order in decided:
            orders.setdefault(order.robot_id, []).append(order.packed())
        for number, packed in orders.items():
            self._said[number] = central_io.orders_message(self._tick, packed)
            self._orders[number].publish(self._said[number])

    def forget(self, name: str, *, is_gone: bool) -> None:
        """Stop waiting for a robot until it reports again.

        Args:
            is_gone: Whether it is taken for gone.
        """
        if name not in self._numbers:
            return
        self._awaited.discard(self._numbers[name])
        if is_gone:
            self._team.forget(self._numbers[name])
        self._decide_if_all()

    def tell(self) -> None:
        """Report what the centre has cost; before robots hear it only that it is alive."""
        is_late = time.monotonic() > self._meets_until
        self._is_met = self._is_met or is_late or self._hears_all()
        figures = CentreReported(self._centre.as_json(len(self._numbers)))
        self._events.write(figures if self._is_met else Alive())
        self._rejections.tell(time.monotonic())

    def _hears_all(self) -> bool:
        """Whether topics lead both ways between the centre and each robot."""
        return all(
            self._orders[number].get_subscription_count() > 0
            and self._node.count_publishers(f"/{name}/{central_io.REPORT}") > 0
            for name, number in self._numbers.items()
            if number in self._awaited
        )


def _team(config: Mapping[str, Any]) -> ReservationCentre:
    settings = read_node_settings(config["name"], config["params"])
    sites = settings.sites
    grid = sites.zones.mark(load_map(config["map"]).upright().refined())
    central = central_from_texts({name: str(value) for name, value in config["central"].items()})
    given = {name: getattr(central, name) for name in config["central"]}
    specs = [load_robot(model) for model in config["models"]]
    first = 1 + int(time.time()) % (MOST_COMMANDS - 1)
    return ReservationCentre(settings.config, specs, grid, sites, given, first_command=first)


def main(arguments: list[str] | None = None) -> int:
    """Run until SIGTERM; returns the exit code."""
    child = StartedProcess("Centre of a swarm", MISSION, arguments)
    ros_env.set_defaults()
    try:
        node = CentralNode(child.config, child.events)
    except SwarmError as error:
        return child.refuse(error)
    child.events.write(Ready())
    due = 0.0
    while not child.is_stopping and not node.refusal:
        node.executor.spin_once(timeout_sec=TURN_PERIOD)
        for command in child.commands():
            if isinstance(command, RobotGone | RobotDead | RobotSilent):
                node.forget(command.robot, is_gone=isinstance(command, RobotGone))
        if time.monotonic() >= due:
            due = time.monotonic() + FIGURES_PERIOD
            node.tell()
    node.tell()
    return child.refuse(node.refusal) if node.refusal else 0


if __name__ == "__main__":
    leave(main())

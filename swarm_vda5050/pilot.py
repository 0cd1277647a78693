"""One robot of the swarm, driven as its vehicle wants; what it says of itself is published."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Container, Sequence
from datetime import UTC, datetime
from functools import partial
from typing import Any

import msgspec
import numpy as np
import shapely
from geometry_msgs.msg import Point, PoseWithCovarianceStamped
from nav2_msgs.action import DriveOnHeading, FollowPath, NavigateThroughPoses, NavigateToPose, Spin
from nav2_msgs.msg import SpeedLimit
from nav_msgs.msg import OccupancyGrid, Path
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import BatteryState as BatteryMsg
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware import directed_io, ros_io
from swarm_common.middleware.courier_io import EndedGoal, StepLink, TickRelease, TickReport
from swarm_common.middleware.rejections import RejectedError, Rejections
from swarm_common.middleware.ros_io import read_battery
from swarm_common.middleware.ros_poll import PolledTopic
from swarm_common.model.battery import BatteryReading, SupplyStatus
from swarm_common.model.palette import BY_HAND
from swarm_common.model.records import (
    CONTROL_PERIOD,
    FloatArray,
    LidarSpec,
    Pose,
    RobotSpec,
    wrap_angle,
)
from swarm_common.model.zones import DirectedZone
from swarm_run.robots.client import RobotCommander
from swarm_run.robots.driver import has_goal, is_final, is_for_good
from swarm_run.robots.status_check import StatusCheck
from swarm_run.robots.task import Task, TaskResult
from swarm_vda5050.conformance import Heard
from swarm_vda5050.dialect import MESSAGES, Dialect, Identity
from swarm_vda5050.factsheet import factsheet, localization_score
from swarm_vda5050.faults import ActiveError, OrderFault, OrderRejectedError
from swarm_vda5050.fine import MOST_MOVES, next_move
from swarm_vda5050.link import Address, BrokerEvent, BrokerEventKind, Link
from swarm_vda5050.map_server import DownloadEvent, MapServerClient
from swarm_vda5050.messages import (
    AgvPosition,
    AgvVelocity,
    BatteryState,
    Header,
    Info,
    NodePosition,
    OrderAction,
    Reference,
    SafetyState,
    VehicleState,
)
from swarm_vda5050.order_check import DrivingArea
from swarm_vda5050.paths import intermediate_path, planned_path
from swarm_vda5050.reading import FieldError
from swarm_vda5050.vehicle import DriveLeg, RobotSenses, Vehicle
from swarm_vda5050.ways import ALONG

STATE_PERIOD = 30.0  # [s] of wall time between two states at the latest
VISUAL_PERIOD = 1.0  # [s] of wall time between two messages for visualization
CANCEL_PERIOD = 2.0  # [s] of wall time after which a robot that drives on is told again to stop
STATUS_TICKS = 5  # between two looks in lockstep
ACTIONS: dict[str, Any] = {
    "navigate_to_pose": NavigateToPose,
    "navigate_through_poses": NavigateThroughPoses,
    "follow_path": FollowPath,
    "spin": Spin,
}
STRAIGHT = "drive_on_heading"  # asked for with the first fine positioning
FINE_SPEED = 0.1  # [m/s] of it
DRIVE_SLACK = 0.05  # [m] before its end at which a navigator ends a straight way
NO_WAY = np.zeros((0, 2))
STILL = 0.02  # [m/s], [rad/s] below which a robot stands
MOVED = 0.05  # [m], [rad] beyond which a robot that stands has another place
WAITING = ("waiting", "holding", "yielding")  # states in which `detail` says for whom
RETAINED = "the broker kept this message from before; it is not done: send it without `retain`"
OBSTACLE = "before an obstacle"  # how `detail` ends of a robot that stopped for somebody
AWAITED = re.compile(r"\bfor ([^\s,:]+)")  # in `detail`: a robot, or something else


class Pilot:
    """One robot: its vehicle, its MQTT connection and its navigator."""

    def __init__(
        self,
        node: Node,
        identity: Identity,
        spec: RobotSpec,
        ground: DrivingArea,
        address: Address,
        *,
        door: StatusCheck,
        is_realistic: bool,
        follows_edges: bool,
        names: Container[str],
        note: Callable[[str], None],
        judge: Callable[[Heard], None] | None = None,
        is_lenient: bool = False,
        timed: Sequence[tuple[float, OrderAction]] = (),
        log: Callable[[bytes], object] | None = None,
        rejections: Rejections | None = None,
    ) -> None:
        """Attach to a robot, and connect to the broker.

        Args:
            node: Node that all ROS traffic goes through; spinning it is the caller's work.
            door: Check of the statuses of all robots.
            names: Names of all robots, for messages about them; may change.
            is_realistic: Whether the robot estimates its pose; otherwise it knows it.
            follows_edges: See `Vehicle`.
            judge: Counts what the fleet control keeps and breaks; None for no verdict.
            timed: Faults that begin by themselves, with their simulated time [s].
            log: Writes a line for logReport.
            rejections: Counts reports that are rejected, in lockstep; None in free run.
        """
        self.name = identity.serial
        self._may_back = _sees_behind(spec.lidar)
        self.vehicle = Vehicle(
            ground,
            identity.offered,
            spec.circumscribed_radius,
            identity.version,
            spec.max_vel_theta,
            may_back=self._may_back,
            follows_edges=follows_edges,
        )
        self.vehicle.plan_faults(timed)
        self._judge, self._log = judge, log
        self._map_server = MapServerClient(ground.grid)
        self._identity = identity
        self._spec = spec
        self._ground = ground
        self._dialect = Dialect(identity, is_lenient)
        self._note = note
        self._names = names
        self.robot = RobotCommander(
            node,
            self.name,
            self._receive_status,
            with_feedback=False,
            door=door,
            watches_swarm=False,
        )
        self._speed = node.create_publisher(
            SpeedLimit, f"/{self.name}/speed_limit", ros_io.RELIABLE
        )
        self._keepout = node.create_publisher(
            OccupancyGrid, f"/{self.name}/keepout_filter_mask", ros_io.LATCHED
        )
        if identity.major > 2 and rejections is None:
            self._directions = node.create_publisher(
                directed_io.KIND, f"/{self.name}/{directed_io.TOPIC}", ros_io.LATCHED
            )
        self._corridors: list[shapely.Geometry] = []  # of the leg that was sent
        # zones and corridors that the navigator knows
        self._area: tuple[object, ...] = ({}, [])
        self._directed: tuple[DirectedZone, ...] = ()
        self._speed_limit = 0.0  # [m/s] that the navigator knows; 0 for none
        self._battery: BatteryReading | None = None
        if spec.battery is not None:
            node.create_subscription(
                BatteryMsg,
                f"/{self.name}/battery_state",
                self._receive_battery,
                ros_io.RELIABLE,
                raw=True,
            )
        self._deviation: float | None = None if is_realistic else 0.0  # [m]
        if is_realistic:
            node.create_subscription(
                PoseWithCovarianceStamped,
                f"/{self.name}/amcl_pose",
                self._receive_pose,
                ros_io.LATCHED,
            )
        self._ways: dict[str, FloatArray] = {}  # [m] in map, by the topic that tells them
        for topic in ("plan", "local_plan") if identity.major > 2 else ():
            node.create_subscription(
                Path, f"/{self.name}/{topic}", partial(self._receive_way, topic), ros_io.LATEST
            )
        self._steps = None if rejections is None else StepLink(node, self.name, rejections)
        self._messages: deque[BrokerEvent] = deque()  # that the next report finds
        self._goals: list[bytes] = []  # sent for the present tick
        self._cancelled: list[bytes] = []  # likewise cancelled
        self._told: dict[str, Any] = {}  # likewise, fields of the release
        self._is_ready = False
        self._moved_from: tuple[int, Pose] | None = None  # tick and pose of the latest velocity
        self._task: Task | None = None
        self._goal: tuple[tuple[str, int], ...] = ()  # nodes that it leads to
        self._turn: tuple[tuple[str, int], ...] | None = None  # legs that end with the turn, if any
        self._follows = False  # whether the leg that was sent follows the lines of edges
        self._fine_moves = 0  # of the present fine positioning
        self._is_fine_move = False  # whether the task is one
        self._sent_at = 0  # tick
        self._ended: Task | None = None  # until the status with the end is here
        self._cancelled_at = 0.0
        self._tick = 0
        self._velocity = AgvVelocity(vx=0.0, vy=0.0, omega=0.0)
        self._is_cut = False  # as simulated
        self._is_silent = False  # its navigator does not run
        self._published: VehicleState | None = None
        self._state_at = 0.0
        self._visual_at = 0.0
        self._is_refused = False
        topics = [identity.topic(name) for name in identity.topics]
        self._link = Link(address, topics, self._will, self.name)
        self._link.open()

    # From swarm-up

    def silence(self) -> None:
        """The navigator died: the broker is to say so."""
        self._is_silent, self._is_ready = True, False
        self._task = self._ended = self._turn = None
        self._is_fine_move = False
        # the next one has heard of nothing
        self._area, self._directed, self._speed_limit = ({}, []), (), 0.0
        if self._steps is not None:
            self._steps.forget()
        self.robot.forgetTask()
        self._link.cut()

    def hear(self) -> None:
        """The navigator runs again: go on with the order."""
        if self._is_silent:
            self._is_silent = False
            self._link.open()

    def close(self) -> None:
        """Say goodbye to the fleet control."""
        self._stop()
        payload = self._dialect.write("connection", {"connectionState": "OFFLINE"})
        self._link.close(self._identity.topic("connection"), payload)

    # Turns

    def turn(self, now: float) -> None:
        """Receive what arrived, drive, and publish.

        Args:
            now: Wall time [s].
        """
        self._hear_broker()
        if self._is_silent:
            return
        self.robot.look()
        if self._steps is None:
            self._drive(now)
        requests = self.vehicle.take_requests()
        if requests.initial_pose_map is not None:
            pose = ros_io.pose_stamped(requests.initial_pose_map, self._tick)
            self.robot.setInitialPose(pose)
        if requests.factsheet:
            self._publish_factsheet()
        for reason in requests.log_reasons:
            self._write_log(reason)
        for download in requests.downloads:
            self._map_server.begin(download)
        for event in self._map_server.poll():
            if event.problem is None:
                self.vehicle.begin_download(event.action_id)
            else:
                self._end_download(event)
        self._simulate_link()
        self._publish(now, is_asked=requests.state)

    def _end_download(self, event: DownloadEvent) -> None:
        zone_set, problem = None, event.problem or ""
        try:
            zone_set = self._dialect.zone_set(event.data) if event.data else None
        except FieldError as error:
            problem = str(error)
        self.vehicle.end_download(event.action_id, problem, zone_set)

    def _write_log(self, reason: str) -> None:
        at = CONTROL_PERIOD * self._tick
        report = {"robot": self.name, "time": at, "reason": reason, "state": self._state()}
        if self._log is not None:
            self._log(msgspec.json.encode(report))

    def _simulate_link(self) -> None:
        """Break the connection, or make it again, as a simulated fault wants."""
        is_cut = self.vehicle.simulated.is_cut
        if is_cut and not self._is_cut:
            self._link.cut()
        elif self._is_cut and not is_cut:
            self._link.open()
        self._is_cut = is_cut

    @property
    def topic(self) -> PolledTopic | None:
        """Where the robot reports its ticks; None in free run."""
        return None if self._steps is None else self._steps.topic

    def step(self) -> None:
        """In lockstep, decide on the tick that the robot has reported, and release it."""
        if self._steps is None or not (self._is_ready or self._find_robot()):
            return
        while (report := self._steps.take()) is not None:
            self._hear_broker()
            ended = [
                each
                for each in report.ended
                if self._task is not None and self._task.goal_id == each.goal
            ]
            if not self._is_silent and (ended or self._messages or report.tick % STATUS_TICKS == 0):
                self._decide(report, ended)
            release = TickRelease(report.tick, self._goals, self._cancelled, **self._told)
            self._steps.release(release)
            self._goals, self._cancelled, self._told = [], [], {}

    def _find_robot(self) -> bool:
        found = [self.robot.offers(name, kind) for name, kind in ACTIONS.items()]
        self._is_ready = all(found)
        return self._is_ready

    def _decide(self, report: TickReport, ended: list[EndedGoal]) -> None:
        """Receive the state of the robot and what the fleet control has sent, then drive."""
        pose_map = Pose(report.x, report.y, report.yaw)
        before = self._moved_from
        if before is None or report.tick >= before[0] + STATUS_TICKS:
            if before is not None:
                passed = CONTROL_PERIOD * (report.tick - before[0])
                self._velocity = _velocity(before[1], pose_map, passed)
            self._moved_from = report.tick, pose_map
        self._tick = report.tick
        is_charging = None if self._spec.battery is None else report.is_charging
        self._sense(pose_map, is_by_hand=report.is_by_hand, is_charging=is_charging)
        for each in ended:
            self._task, goal, self._goal = None, self._goal, ()
            self._end(goal, each.is_reached, each.reason, is_final(each.code, each.reason))
        task = self._task
        if task is not None and report.goal != task.goal_id and self._sent_at < report.tick:
            self._task, self._goal, self._turn = None, (), None  # its navigator was started again
            self._is_fine_move = False
        while self._messages:
            self._receive_message(self._messages.popleft())
        self._drive(CONTROL_PERIOD * report.tick)

    def _hear_broker(self) -> None:
        while not self._link.inbox.empty():
            self._receive(self._link.inbox.get())

    def _receive(self, arrival: BrokerEvent) -> None:
        if arrival.kind is BrokerEventKind.REFUSED:
            if not self._is_refused:
                self._is_refused = True
                reason = arrival.payload.decode()
                self._note(f"{self.name}: the MQTT broker does not take it: {reason}; it tries on")
        elif arrival.kind is BrokerEventKind.CONNECTED:
            self._is_refused = False
            payload = self._dialect.write("connection", {"connectionState": "ONLINE"})
            self._link.publish(self._identity.topic("connection"), payload, is_kept=True)
            self._publish_factsheet()
            self._published = None
        elif self._steps is not None:
            self._messages.append(arrival)
        else:
            self._receive_message(arrival)

    def _receive_message(self, arrival: BrokerEvent) -> None:
        """Give the vehicle a message; one that the broker kept from before is never done."""
        name = arrival.topic.rpartition("/")[2]
        if not arrival.payload:
            return  # the broker was told to forget what it kept
        message: Header | None
        has_waited = self.vehicle.waits_for_base
        try:
            if arrival.is_retained:
                self._note(f"{arrival.topic}: {RETAINED}")
                raise OrderRejectedError(OrderFault.VALIDATION, f"{name}: {RETAINED}", topic=name)
            message = self._dialect.read(name, arrival.payload)
        except OrderRejectedError as error:
            message = None
            self.vehicle.reject(error, MESSAGES[name])
            answers = [ActiveError(error.fault, str(error), error.references)]
            self._dialect.forgiven = []
        else:
            answers = self.vehicle.receive(message)
        if self._judge is not None:
            forgiven = self._dialect.forgiven
            is_kept, payload = arrival.is_retained, arrival.payload
            self._judge(
                Heard(self.name, name, payload, is_kept, message, answers, forgiven, has_waited)
            )

    # Driving

    def _drive(self, now: float) -> None:
        leg = self.vehicle.leg
        keys = () if leg is None else tuple(node.key for node in leg.nodes)
        is_new = self._task is None or self._goal[-len(keys) :] != keys
        if leg is not None and leg.is_followed != self._follows:
            self._follows, is_new = leg.is_followed, True  # a corridor was granted, or is lost
        if leg is not None and is_new:
            self._corridors = self.vehicle.corridors_of(leg)
        elif not self.vehicle.is_busy:
            self._corridors = []
        knows_area = self._forbid()
        target = self.vehicle.fine_target
        if target is None:
            self._fine_moves = 0
        elif self._task is None or self._is_fine_move:
            self._stand_exactly(target)
            return
        if leg is None or self._ended is not None:
            if self._task is not None or self._drives_on(now):
                self._stop()
                self._cancelled_at = now
            return
        if is_new:
            if not knows_area:
                return
            self._send(leg)
            self._goal = keys
        assert self.vehicle.senses is not None
        here = self.vehicle.senses.pose_map
        limit = min(leg.max_speed or math.inf, self.vehicle.zones.limit_at(here.x, here.y))
        self._limit_speed(limit if limit < math.inf else 0.0)

    def _forbid(self) -> bool:
        """Tell the navigator where it must not drive; return whether it has heard of it."""
        zones, corridors = self.vehicle.zones, self._corridors
        directed, area = zones.directed, (zones.costs, corridors)
        has_changed = (area, directed) != (self._area, self._directed)
        if area != self._area:
            mask = ros_io.grid_msg(zones.mask(self._ground.grid, corridors), self._tick)
            if self._steps is None:
                self._keepout.publish(mask)
            else:
                self._told["keepout"] = bytes(serialize_message(mask))
        if directed != self._directed:
            if self._steps is None:
                self._directions.publish(directed_io.packed_zones(directed))
            else:
                self._told["directed"] = directed_io.packed_zones(directed)
        self._area, self._directed = area, directed
        if self._steps is not None:
            return True
        is_free = not zones.costs and not corridors
        knows_mask = is_free or self._keepout.get_subscription_count() > 0
        knows_directions = not directed or self._directions.get_subscription_count() > 0
        return not has_changed and knows_mask and knows_directions

    def _drives_on(self, now: float) -> bool:
        """Whether the robot follows a goal of ours although it was told to stop."""
        task, status = self.robot.task, self.robot.status
        is_known = self._ended is not None or self._steps is not None  # to have ended
        if is_known or task is None or task.is_complete or status is None:
            return False
        return has_goal(status) and now - self._cancelled_at > CANCEL_PERIOD

    def _stop(self) -> None:
        if self._task is not None:
            self._cancelled.append(self._task.goal_id)
        self._task = self._turn = None
        self._goal, self._is_fine_move = (), False
        self.robot.cancelTask()

    def _send(self, leg: DriveLeg) -> None:
        assert self.vehicle.senses is not None
        yaw = self.vehicle.senses.pose_map.yaw
        if leg.heading is not None and abs(turn := wrap_angle(leg.heading - yaw)) > ALONG:
            self._begin_turn(turn, ())
            return
        if (path := self.vehicle.path_of(leg)) is not None:
            self._send_path(leg, path)
            return
        poses = []
        for node in leg.nodes:
            position = node.node_position
            assert position is not None
            pose_map = Pose(position.x, position.y, wrap_angle(position.theta or 0.0))
            poses.append(ros_io.pose_stamped(pose_map, self._tick))
        end = leg.nodes[-1].node_position
        tree = ros_io.ANY_HEADING if end is None or end.theta is None else ""
        if len(poses) == 1:
            goal = NavigateToPose.Goal(pose=poses[0], behavior_tree=tree)
            self._begin("navigate_to_pose", goal)
        else:
            goals = NavigateThroughPoses.Goal(poses=poses, behavior_tree=tree)
            self._begin("navigate_through_poses", goals)

    def _stand_exactly(self, target: NodePosition) -> None:
        """Begin the next move of a fine positioning, once the robot stands after the one before."""
        if self._task is not None or self._ended is not None or self.is_driving:
            return
        assert self.vehicle.senses is not None
        move = next_move(self.vehicle.senses.pose_map, target, may_back=self._may_back)
        if move is None:
            self.vehicle.end_fine_positioning("")
        elif self._fine_moves >= MOST_MOVES:
            self.vehicle.end_fine_positioning(f"after {MOST_MOVES} moves")
        elif move.turn:
            self._begin_move("spin", Spin.Goal(target_yaw=move.turn))
        elif self.robot.offers(STRAIGHT, DriveOnHeading):  # else soon
            sign = math.copysign(1.0, move.distance)
            way = Point(x=move.distance + sign * DRIVE_SLACK)
            speed = sign * min(FINE_SPEED, self._spec.max_vel_x)
            self._begin_move(STRAIGHT, DriveOnHeading.Goal(target=way, speed=speed))

    def _begin_move(self, action: str, goal: Any) -> None:
        self._begin(action, goal)
        self._fine_moves += 1
        self._is_fine_move = True

    def _begin(self, action: str, goal: Any) -> None:
        on_end = self._receive_end if self._steps is None else None
        kind = DriveOnHeading if action == STRAIGHT else ACTIONS[action]
        self._task = self.robot.send(action, kind, goal, on_end)
        self._goals.append(self._task.goal_id)
        self._sent_at = self._tick

    def _send_path(self, leg: DriveLeg, path: FloatArray) -> None:
        """Send a path to follow, from the point on that is nearest to the robot."""
        assert self.vehicle.senses is not None
        here, end = self.vehicle.senses.pose_map, leg.nodes[-1].node_position
        path = path[int(np.hypot(path[:, 0] - here.x, path[:, 1] - here.y).argmin()) :]
        message = ros_io.path_msg(path, self._tick)
        if end is not None and end.theta is not None:
            last = Pose(float(path[-1, 0]), float(path[-1, 1]), end.theta)
            message.poses[-1] = ros_io.pose_stamped(last, self._tick)
        controller = ros_io.BACKWARDS if leg.is_backwards else ""
        self._begin("follow_path", FollowPath.Goal(path=message, controller_id=controller))

    def _limit_speed(self, limit: float) -> None:
        if limit != self._speed_limit:
            self._speed_limit = limit
            if self._steps is not None:
                self._told["speed_limit"] = limit
                return
            self._speed.publish(SpeedLimit(speed_limit=limit, percentage=False))

    def _receive_end(self, task: Task) -> None:
        if task is self._task:
            self._task = None
            self._ended = task

    def _settle(self) -> None:
        """Tell the vehicle how its leg ended; called with a status from after the end."""
        task, self._ended = self._ended, None
        goal, self._goal = self._goal, ()
        if task is None or not (goal or self._is_fine_move) or task.is_forgotten:
            self._turn, self._is_fine_move = None, False
            return  # a forgotten goal is sent anew
        is_reached = task.outcome is TaskResult.SUCCEEDED
        self._end(goal, is_reached, task.reason, not is_reached and is_for_good(task.result))

    def _end(
        self, goal: tuple[tuple[str, int], ...], is_reached: bool, reason: str, is_final: bool
    ) -> None:
        """A leg ended, or a turn before or after one; a robot off its heading turns once more.

        Who makes way in the midst of a turn ends it off the heading.
        """
        turn, self._turn = self._turn, None
        if self._is_fine_move:
            self._is_fine_move = False
            if not is_reached and (is_final or self._fine_moves >= MOST_MOVES):
                self.vehicle.end_fine_positioning(reason)
        elif not is_reached:
            self.vehicle.fail_drive(reason, is_final)
        elif turn == ():
            return  # the leg follows
        elif angle := self.vehicle.turn_at(goal[-1]):
            self._begin_turn(angle, goal)
            self._goal = goal
        else:
            self.vehicle.arrive(goal[-1])

    def _begin_turn(self, angle: float, ends: tuple[tuple[str, int], ...]) -> None:
        """Turn on the spot.

        Args:
            angle: [rad]
            ends: Leg that has arrived with the turn; empty before a leg.
        """
        self._begin("spin", Spin.Goal(target_yaw=angle))
        self._turn = ends

    # From the robot

    def _receive_status(self, status: RobotStatus) -> None:
        if self._steps is not None:
            return  # it reports
        tick = ros_io.tick_of(status.stamp)
        pose_map = Pose(status.pose.x, status.pose.y, status.pose.theta)
        before = self.vehicle.senses
        if before is not None and tick > self._tick:
            self._velocity = _velocity(
                before.pose_map, pose_map, CONTROL_PERIOD * (tick - self._tick)
            )
        self._tick = tick
        is_by_hand = status.state == BY_HAND
        self._sense(pose_map, is_by_hand=is_by_hand, is_charging=self._is_charging)
        if self._ended is not None:
            self._settle()

    def _sense(self, pose_map: Pose, *, is_by_hand: bool, is_charging: bool | None) -> None:
        """Tell the vehicle how the robot is."""
        self.vehicle.sense(
            RobotSenses(
                now=CONTROL_PERIOD * self._tick,
                pose_map=pose_map,
                is_standing=self._task is None and self._ended is None and not self.is_driving,
                is_by_hand=is_by_hand,
                is_charging=is_charging,
                utc=datetime.now(UTC),
            )
        )

    def _receive_battery(self, data: bytes) -> None:
        try:
            self._battery = read_battery(data)
        except RejectedError as error:
            self._note(f"{self.name}: a battery_state is left out: {error}")

    def _receive_pose(self, message: PoseWithCovarianceStamped) -> None:
        covariance = message.pose.covariance
        self._deviation = math.sqrt(max(covariance[0], covariance[7], 0.0))

    def _receive_way(self, topic: str, message: Path) -> None:
        places = [(each.pose.position.x, each.pose.position.y) for each in message.poses]
        points = np.array(places).reshape(-1, 2)
        if np.isfinite(points).all():
            self._ways[topic] = points

    @property
    def is_driving(self) -> bool:
        """Whether the robot moves."""
        v = self._velocity
        return max(abs(v.vx), abs(v.vy), abs(v.omega)) > STILL

    @property
    def _is_charging(self) -> bool | None:
        if self._spec.battery is None:
            return None
        return self._battery is not None and self._battery.status is SupplyStatus.CHARGING

    # To the fleet control

    def _will(self) -> tuple[str, bytes]:
        state = {"connectionState": "CONNECTIONBROKEN"}
        return self._identity.topic("connection"), self._dialect.write("connection", state)

    def _publish_factsheet(self) -> None:
        content = factsheet(self._spec, self._identity.offered, self._identity.version)
        payload = self._dialect.write("factsheet", content)
        self._link.publish(self._identity.topic("factsheet"), payload, is_kept=True)

    def _publish(self, now: float, *, is_asked: bool) -> None:
        state = self._state()
        if state is None or not self._link.is_open:
            return
        if not is_asked and now - self._state_at < self.vehicle.simulated.state_period:
            return
        is_new = self._published is None or is_news(state, self._published)
        if is_asked or is_new or now - self._state_at >= STATE_PERIOD:
            self._published, self._state_at = state, now
            self._send_message("state", state)
        if now - self._visual_at >= VISUAL_PERIOD:
            self._visual_at = now
            visual = {
                "agvPosition": state.agv_position,
                "velocity": state.velocity,
                "plannedPath": state.planned_path,
                "intermediatePath": state.intermediate_path,
            }
            self._send_message("visualization", visual)

    def _send_message(self, topic: str, content: Any) -> None:
        payload = self._dialect.write(topic, content)
        self._link.publish(self._identity.topic(topic), payload)

    def _state(self) -> VehicleState | None:
        vehicle = self.vehicle
        if vehicle.senses is None:  # before its first tick it knows no place
            return None
        status = self.robot.status or RobotStatus(robot=self.name, state="idle")
        return VehicleState(
            order_id=vehicle.order_id,
            order_update_id=vehicle.order_update_id,
            last_node_id=vehicle.last_node[0],
            last_node_sequence_id=vehicle.last_node[1],
            node_states=vehicle.node_states,
            edge_states=vehicle.edge_states,
            driving=self.is_driving,
            paused=vehicle.is_paused,
            new_base_request=vehicle.wants_base,
            distance_since_last_node=round(vehicle.driven, 2),
            agv_position=self._position(vehicle.senses.pose_map),
            velocity=self._velocity,
            loads=() if vehicle.load is None else (vehicle.load,),
            action_states=vehicle.action_states,
            instant_action_states=vehicle.instant_action_states,
            battery_state=self._battery_state(),
            operating_mode=vehicle.operating_mode,
            errors=tuple(self._dialect.error(report) for report in vehicle.errors),
            information=_information(status, self._names),
            safety_state=SafetyState(
                e_stop=vehicle.simulated.emergency_stop,
                field_violation=status.detail.endswith(OBSTACLE),
            ),
            planned_path=planned_path(
                self._way("plan"), [node for node, _ in self._goal if self._turn is None]
            ),
            intermediate_path=intermediate_path(
                self._way("local_plan"), self._spec.max_vel_x, vehicle.senses.utc
            ),
            zone_sets=vehicle.zones.states,
            zone_requests=vehicle.zones.requests,
            zone_action_states=vehicle.zone_action_states,
            edge_requests=vehicle.edge_requests,
            maps=vehicle.maps.states,
        )

    def _way(self, topic: str) -> FloatArray:
        """Return the latest way (n, 2) [m] in map of a topic; none of a robot without a goal."""
        return self._ways.get(topic, NO_WAY) if self._task is not None else NO_WAY

    def _position(self, pose_map: Pose) -> AgvPosition:
        deviation, is_lost = self._deviation, self.vehicle.simulated.is_lost
        score = None if deviation is None else localization_score(deviation)
        return AgvPosition(
            x=round(pose_map.x, 4),
            y=round(pose_map.y, 4),
            theta=wrap_angle(pose_map.yaw),
            map_id=self._ground.map_id,
            position_initialized=not is_lost,
            localization_score=0.0 if is_lost else score,
            deviation_range=deviation,
        )

    def _battery_state(self) -> BatteryState:
        battery, reading = self._spec.battery, self._battery
        if (charge := self.vehicle.simulated.charge) is not None:
            return BatteryState(battery_charge=charge, charging=False)
        if battery is None or reading is None:
            return BatteryState(battery_charge=100.0, charging=False)
        return BatteryState(
            battery_charge=round(100.0 * reading.share, 1),
            charging=reading.status is SupplyStatus.CHARGING,
            battery_voltage=battery.voltage,
        )


def _sees_behind(lidar: LidarSpec) -> bool:
    """Whether a LiDAR sees all around; without, a robot drives no edge backwards."""
    return (lidar.rays + 1) * lidar.angle_increment > math.tau - 1e-3


def is_news(state: VehicleState, before: VehicleState) -> bool:
    """Return whether a state is published at once after one that was.

    A robot that stands elsewhere is news: at full speed it may have driven between two looks.
    """
    here, there = state.agv_position, before.agv_position
    if here is not None and there is not None and not state.driving:
        way = math.hypot(here.x - there.x, here.y - there.y)
        if max(way, abs(wrap_angle(here.theta - there.theta))) > MOVED:
            return True
    return _essence(state) != _essence(before)


def _essence(state: VehicleState) -> VehicleState:
    replace = msgspec.structs.replace
    information = tuple(replace(info, info_description=None) for info in state.information)
    charge = replace(state.battery_state, battery_charge=0.0)
    return replace(
        state,
        agv_position=None,
        velocity=None,
        planned_path=None,
        intermediate_path=None,
        distance_since_last_node=None,
        battery_state=charge,
        information=information,
    )


def _information(status: RobotStatus, names: Container[str]) -> tuple[Info, ...]:
    """Return what the robot does, for people; of one that waits, for whom."""
    if status.state not in WAITING:
        return (Info(info_type=status.state.replace(" ", "_").upper(), info_level="DEBUG"),)
    references = tuple(
        Reference(reference_key="serialNumber", reference_value=other)
        for other in AWAITED.findall(status.detail)
        if other in names
    )
    return (
        Info(
            info_type=status.state.upper(),
            info_level="INFO",
            info_description=f"{status.state} {status.detail}",
            info_references=references or None,
        ),
    )


def _velocity(before_map: Pose, now_map: Pose, duration: float) -> AgvVelocity:
    """Return the mean velocity between two poses, in the robot's frame."""
    dx, dy = now_map.x - before_map.x, now_map.y - before_map.y
    turn = wrap_angle(now_map.yaw - before_map.yaw)
    yaw = before_map.yaw + 0.5 * turn
    cos, sin = math.cos(yaw), math.sin(yaw)
    return AgvVelocity(
        vx=round((cos * dx + sin * dy) / duration, 3) + 0.0,
        vy=round((cos * dy - sin * dx) / duration, 3) + 0.0,  # never -0
        omega=round(turn / duration, 3) + 0.0,
    )

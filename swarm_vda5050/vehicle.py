"""One robot as a vehicle of VDA 5050: orders, actions and state, without input and output.

Messages come in decoded (`receive`), and what the robot is like
comes in with `sense`. What the robot is to do is asked for: `leg` says where to drive, `requests`
what to publish or send once. A node between the ends of a leg is traversed when the robot passes
it; the end of a leg is traversed when the robot reports that it stands there (`arrive`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any, NamedTuple

import msgspec
import numpy as np
import shapely

from swarm_common.model.records import FloatArray, Pose, wrap_angle
from swarm_vda5050.actions import (
    OFFERED,
    OPEN_ENDED,
    ActionOffer,
    ActionScope,
    RunningAction,
    check_action,
)
from swarm_vda5050.faults import ActiveError, OrderFault, OrderRejectedError
from swarm_vda5050.fine import rest_of
from swarm_vda5050.maps import Download, MapKeeper
from swarm_vda5050.messages import (
    ActionState,
    ActionStatus,
    DriveOrder,
    Edge,
    EdgeRequest,
    EdgeState,
    Header,
    InstantActions,
    Node,
    NodePosition,
    NodeState,
    OrderAction,
    OrderPart,
    Responses,
    VehicleLoad,
    ZoneSet,
    ZoneSetMessage,
)
from swarm_vda5050.order_check import STOP_RADIUS, DrivingArea, check_order
from swarm_vda5050.requests import RequestBook, RequestKey
from swarm_vda5050.simulated_faults import DRIVES_ON, INTERVENED, SIMULATED, SimulatedFaults
from swarm_vda5050.tally import OrderTally
from swarm_vda5050.ways import (
    corridor_area,
    is_backwards,
    is_followed,
    keeps_heading,
    line_of,
    needs_release,
)
from swarm_vda5050.zone_actions import ZoneActions
from swarm_vda5050.zones import ZoneKeeper

PASS_RADIUS = 0.7  # [m] around a node without allowedDeviationXY: that of NavigateThroughPoses
BY_HAND = "the order was given up: somebody drives the robot by hand"
CANCELLED = "cancelled"
USUAL_TURN, LEAST_TURN = 0.25, 0.05  # [rad] off a heading: without a deviation, and at least
LOG_FILE = "vda5050_log.jsonl"  # in the run's folder
CORRIDOR = "CORRIDOR"  # requestType
CORRIDORS_AHEAD = 3  # that are asked for at once
MOST_ASKED = 20  # edges of a way that is asked for
ON_LINE = 0.1  # [m] from the line of an edge within which the robot has returned to it
LEEWAY = 0.2  # [m] beyond the border of a corridor up to which the robot has not left it
MOST_TRIES = 3  # of a leg
LONG_AGO = datetime.min.replace(tzinfo=UTC)
RETRY_PAUSE = 5.0  # [s] between two of them
MOST_LEFT = 5000  # nodes of an order that are not traversed yet
MOST_KEPT = 50  # errors of a kind, instant actions that ended
MOST_USED = 10_000  # orders and instant actions that are remembered: none is done twice


@dataclass(frozen=True, slots=True)
class RobotSenses:
    """State of the robot as its vehicle receives it."""

    now: float  # simulated time [s]
    pose_map: Pose  # where the robot is
    is_standing: bool = True  # whether it stands and has no goal
    is_by_hand: bool = False  # whether somebody drives it by hand
    # whether current flows into its battery; None without a battery
    is_charging: bool | None = None
    utc: datetime = LONG_AGO  # time at which releases of zones are compared with their end


class DriveLeg(NamedTuple):
    """Nodes to drive through without a stop, forwards or backwards, to the last.

    `max_speed` [m/s] holds to the first. The robot turns to a `heading` [rad] before it sets off.
    """

    nodes: tuple[Node, ...]
    max_speed: float | None
    heading: float | None = None
    is_backwards: bool = False
    is_followed: bool = False  # whether the lines of edges are, in place of a way of its own


@dataclass(frozen=True, slots=True)
class Requests:
    """Messages to be published or sent once."""

    state: bool = False
    factsheet: bool = False
    initial_pose_map: Pose | None = None
    log_reasons: tuple[str, ...] = ()
    downloads: tuple[Download, ...] = ()


class Vehicle:
    """The protocol of one robot.

    Attributes:
        order_id: Id of the latest order; empty before the first.
        order_update_id: Update id of the latest order.
        last_node: Id and sequence id of the node traversed last.
        load: What the robot carries; None for nothing.
        is_paused: Whether the fleet control made it pause.
        is_manual: Whether somebody drives it by hand.
        driven: Distance [m] since the last node.
        senses: How the robot was last; None before the first word of it.
        maps: Its maps.
        requests: What it asks its fleet control for; of 3.0.
        zones: Its zone sets; of 3.0.
        simulated: Faults on demand.
        tally: Orders so far.
    """

    def __init__(
        self,
        ground: DrivingArea,
        offered: Mapping[str, ActionOffer] = OFFERED["2.1"],
        radius: float = 0.0,
        version: str = "2.1",
        turn_rate: float = math.inf,
        *,
        may_back: bool = True,
        follows_edges: bool = False,
    ) -> None:
        """Begin without an order.

        Args:
            offered: Actions of the version, by actionType.
            radius: [m] of the robot's body.
            turn_rate: [rad/s] that it turns at most.
            may_back: Whether it drives backwards, too.
            follows_edges: Whether it follows edges without a corridor, in place of ways of its own.
        """
        self._follows_edges = follows_edges
        self.maps = MapKeeper(ground.map_id)
        self.requests = RequestBook()
        self.zones = ZoneKeeper(ground.map_id, radius, offered, self.requests)
        self._zone_actions = ZoneActions()
        self._corridor: RequestKey | None = None  # which the robot uses
        self._corridor_error: ActiveError | None = None
        # areas of the present edge with a corridor and of the one before, by order and sequenceId
        self._kept_in: dict[tuple[str, int], shapely.Geometry] = {}
        self._has_been_inside = False  # of them
        self._refuge: Node | None = None  # beside a zone that the robot has to leave
        self.simulated = SimulatedFaults(version)
        self.tally = OrderTally()
        self._timed: list[tuple[float, OrderAction]] = []  # instant actions of ours, by time [s]
        self._answers: list[ActiveError] = []  # to the message that is being received
        self._radius, self._turn_rate, self._may_back = radius, turn_rate, may_back
        self.order_id = ""
        self.order_update_id = 0
        self.last_node = ("", 0)
        self.load: VehicleLoad | None = None
        self.is_paused = False
        self.is_manual = False
        self.driven = 0.0
        self._ground = ground
        self._offered = offered
        self.senses: RobotSenses | None = None
        self._content: object = None  # of the latest order message
        self._nodes: list[Node] = []  # not traversed yet
        self._edges: list[Edge] = []  # whose end is not reached yet
        self._actions: dict[int, list[RunningAction]] = {}  # of the order, by sequence id
        self._instant: dict[str, RunningAction] = {}
        self._used: dict[str, None] = {}  # orderIds
        self._seen: dict[str, OrderAction] = {}  # instant actions, also those that are forgotten
        self._cancelled = ""  # orderId
        self._cancel: RunningAction | None = None  # the action under way
        self._from: Node | None = None  # traversed last
        self._rejections: dict[type[Header], list[ActiveError]] = {}  # by the kind of message
        self._action_errors: list[ActiveError] = []
        self._drive_error: ActiveError | None = None
        self._tries = 0
        self._retry_at = 0.0
        self._is_stuck = False
        self._requests = Requests()

    # What the fleet control sends

    def receive(self, message: Header) -> list[ActiveError]:
        """Accept a message, or report why not; return the errors that answer it."""
        self._answers = []
        try:
            match message:
                case DriveOrder():
                    if self.simulated.takes_order():
                        self._accept(message)
                case InstantActions():
                    for action in message.actions:
                        self._begin_instant(action, message.references)
                case ZoneSetMessage():
                    self.zones.add(message.zone_set)
                    self._rejections.pop(ZoneSetMessage, None)
                case Responses():
                    self._rejections.pop(Responses, None)
                    for problem in self.requests.respond(message.responses):
                        error = OrderRejectedError(OrderFault.VALIDATION, problem)
                        self.reject(error, Responses, topic="responses", **message.references)
        except OrderRejectedError as error:
            self.reject(error, type(message), **message.references)
        self._advance()
        self._ask()
        return self._answers

    def _cross_zones(self, before_map: Pose, now_map: Pose) -> None:
        """Begin and end the actions of zones, unless somebody drives the robot by hand."""
        zones = {} if self.is_manual else self.zones.action_zones
        name = "" if self.is_manual else self.zones.enabled
        if zones or name != self._zone_actions.zone_set:
            way = shapely.LineString([(before_map.x, before_map.y), (now_map.x, now_map.y)])
            body = shapely.Point(now_map.x, now_map.y).buffer(self._radius)
            self._zone_actions.look(zones, name, way.buffer(self._radius), body)

    def plan_faults(self, timed: Sequence[tuple[float, OrderAction]]) -> None:
        """Have instant actions begin at a time, as if a fleet control had sent them then.

        Args:
            timed: Simulated time [s] of each.
        """
        self._timed = sorted(timed, key=lambda pair: pair[0])

    def reject(self, error: OrderRejectedError, kind: type[Header], **more: str) -> None:
        """Report that a message was rejected.

        Args:
            more: References besides those of the error.
        """
        errors = self._rejections.setdefault(kind, [])
        report = ActiveError(error.fault, str(error), {**more, **error.references})
        self._answers.append(report)
        if report not in errors:
            errors.append(report)
            del errors[:-MOST_KEPT]

    # What the robot does

    def sense(self, senses: RobotSenses) -> None:
        """Update the state of the robot; time passes."""
        before, self.senses = self.senses, senses
        self.simulated.pass_time(senses.now)
        while self._timed and self._timed[0][0] <= senses.now:
            self._begin_instant(self._timed.pop(0)[1], {})
        mode = self.simulated.mode or DRIVES_ON[0]
        is_by_hand = senses.is_by_hand or mode not in (*DRIVES_ON, INTERVENED)
        if before is not None:
            self.driven += senses.pose_map.distance(before.pose_map)
        if is_by_hand and not self.is_manual:
            was_busy = self.is_busy
            self._drop_order(BY_HAND)
            self._zone_actions.end(BY_HAND)
            if was_busy:
                self.tally.given_up += 1
                self._drive_error = ActiveError(
                    OrderFault.DRIVING, BY_HAND, {"orderId": self.order_id}
                )
        if self.is_manual and not is_by_hand:
            refused = self._rejections.get(DriveOrder, [])
            refused[:] = [each for each in refused if each.fault is not OrderFault.NOT_AVAILABLE]
        if self.simulated.has_no_place:
            self.last_node = ("", 0)
        self.is_manual = is_by_hand
        if before is not None:
            self._pass_nodes(before.pose_map)
            self._cross_zones(before.pose_map, senses.pose_map)
        self._ask(has_stopped=senses.is_standing)
        self._advance()
        self.tally.pass_time(senses.now, is_busy=self.is_busy and self._cancel is None)

    def arrive(self, end: tuple[str, int]) -> None:
        """The robot stands at the end of a leg.

        Args:
            end: Key of the last node of the leg; one that is no longer awaited does not count.
        """
        keys = [node.key for node in self._nodes]
        if end not in keys or self.senses is None:
            return
        node = self._nodes[keys.index(end)]
        distance = _distance(node, self.senses.pose_map)
        if distance > max(_pass_radius(node), STOP_RADIUS):  # it stops there
            self.fail_drive(f"it is occupied: the robot stands {distance:.1f} m from it", True)
            return
        for _ in range(keys.index(end) + 1):
            self._traverse()
        self._advance()
        self._ask()

    def end_fine_positioning(self, problem: str) -> None:
        """The robot stands on the exact pose, or cannot.

        Args:
            problem: Why not; empty if it does.
        """
        run, target = self._fine, self.fine_target
        if run is None or target is None or self.senses is None:
            return
        rest = rest_of(self.senses.pose_map, target)
        if problem:
            run.miss(f"{rest}: {problem}")
        else:
            run.finish(rest)
        self._advance()

    def begin_download(self, action_id: str) -> None:
        """A server is asked for a map or a zone set."""
        if (run := self._instant.get(action_id)) is not None and run.is_active:
            run.status = ActionStatus.RUNNING

    def end_download(self, action_id: str, problem: str, zone_set: ZoneSet | None = None) -> None:
        """A map or a zone set is here, or cannot be had.

        Args:
            problem: Why not; empty if it is here.
            zone_set: What was fetched, of a zone set.
        """
        run = self._instant.get(action_id)
        if run is None or not run.is_active:
            return
        if run.kind == "downloadZoneSet":
            self._end_zone_set(run, problem, zone_set)
        elif problem:
            self._fail_map(run, OrderFault.ACTION, problem)
        else:
            self.maps.add(run.action.parameter("mapVersion"))
            run.finish("not enabled")

    def fail_drive(self, reason: str, is_final: bool) -> None:
        """The robot gave a leg up; another try follows, unless it would end alike.

        Args:
            is_final: Whether every other try would fail, too.
        """
        if self.senses is not None and self._refuge is not None:
            self._retry_at = self.senses.now + RETRY_PAUSE
            self._drive_error = ActiveError(OrderFault.DRIVING, reason, {})
            return
        if not self._nodes or self.senses is None:
            return
        self._tries += 1
        self._is_stuck = is_final or self._tries >= MOST_TRIES
        self._retry_at = self.senses.now + RETRY_PAUSE
        references = {"orderId": self.order_id, "nodeId": self._nodes[0].node_id}
        fault = OrderFault.UNREACHABLE if self._is_stuck else OrderFault.DRIVING
        self._drive_error = ActiveError(fault, reason, references)

    # What it is to do

    @property
    def leg(self) -> DriveLeg | None:
        """Where to drive; None to stand."""
        is_kept = self.is_paused or self.is_manual or self._cancel is not None
        is_kept = is_kept or self.simulated.holds
        if is_kept or self.senses is None or self.senses.now < self._retry_at:
            return None
        if self._refuge is not None:
            return None if self._is_blocked else DriveLeg((self._refuge,), None)
        is_kept = not self._nodes or not self._nodes[0].released or self._is_blocked
        if is_kept or self._is_stuck or self._corridor_error is not None:
            return None
        way = self._way
        count = self.zones.reach(way, self._lines_ahead(len(way) - 1), self.order_id)
        if count == 0:
            return None
        speed = self._edges[0].max_speed if self._edges else None
        is_backwards = bool(self._edges) and self._is_backwards(0)
        is_line = bool(self._edges) and self._follows(0)
        return DriveLeg(tuple(self._nodes[:count]), speed, self._heading, is_backwards, is_line)

    @property
    def fine_target(self) -> NodePosition | None:
        """The pose on which the robot is to stand exactly; None for none, or not now."""
        is_kept = self.is_paused or self.is_manual or self._cancel is not None
        is_kept = is_kept or self.simulated.holds or self.zones.is_stopped
        is_kept = is_kept or self.zones.is_evacuated
        if is_kept or self._fine is None or self._from is None:
            return None
        return self._from.node_position

    @property
    def _fine(self) -> RunningAction | None:
        runs = (run for run in self._due if run.kind == "finePositioning" and run.is_active)
        return next(runs, None)

    @property
    def _heading(self) -> float | None:
        """The heading [rad] that the present edge wants where the robot is; None for any."""
        if not self._edges or not keeps_heading(self._edges[0]):
            return None
        assert self.senses is not None
        ((_, line),) = self._lines(1)
        here = self.senses.pose_map
        near = int(np.hypot(line[:-1, 0] - here.x, line[:-1, 1] - here.y).argmin())
        dx, dy = line[near + 1] - line[near]
        ahead = math.atan2(dy, dx)
        return wrap_angle(ahead + math.pi) if self._is_backwards(0) else ahead

    def turn_at(self, end: tuple[str, int]) -> float:
        """Return how far [rad] to turn at a node before the robot has its heading; 0 if it has."""
        found = [node.node_position for node in self._nodes if node.key == end]
        if not found or found[0] is None or found[0].theta is None or self.senses is None:
            return 0.0
        allowed = found[0].allowed_deviation_theta or USUAL_TURN
        turn = wrap_angle(found[0].theta - self.senses.pose_map.yaw)
        return turn if abs(turn) > max(allowed, LEAST_TURN) else 0.0

    def path_of(self, leg: DriveLeg) -> FloatArray | None:
        """Return the path (n, 2) [m] in map that is to be followed; None for a way of its own."""
        if not leg.is_followed:
            return None
        return np.vstack([line for _, line in self._lines(len(leg.nodes))])

    def corridors_of(self, leg: DriveLeg) -> list[shapely.Geometry]:
        """Return the areas that the robot must not leave on a leg; none for anywhere."""
        if not self._edges or self._edges[0].corridor is None or leg.is_followed:
            return []
        if leg.nodes[0] is self._refuge:
            return []
        lines = self._lines(len(leg.nodes))
        return [corridor_area(edge, line, self._radius) for edge, line in lines]

    def _lines(self, count: int) -> list[tuple[Edge, FloatArray]]:
        """Return the next edges with their lines (n, 2) [m] in map."""
        lines = []
        before = self._from
        for node, edge in zip(self._nodes[:count], self._edges, strict=False):
            assert before is not None
            assert before.node_position is not None
            assert node.node_position is not None
            lines.append((edge, line_of(edge, before.node_position, node.node_position)))
            before = node
        return lines

    def _follows(self, index: int) -> bool:
        """Whether the robot follows the line of one of the next edges."""
        edge = self._edges[index]
        if is_followed(edge) or (self._follows_edges and edge.corridor is None):
            return True
        if needs_release(edge) and not self._may_leave_line(edge):
            return True
        return self._is_guided(index)

    def _is_guided(self, index: int) -> bool:
        return self.zones.has_lines and self.zones.guides(self._lines(index + 1)[index][1])

    def _is_backwards(self, index: int) -> bool:
        """Whether the robot drives one of the next edges backwards."""
        edge = self._edges[index]
        return edge.orientation is not None and is_backwards(edge, self._lines(index + 1)[index][1])

    def _way_of(self, index: int) -> tuple[bool, bool, bool]:
        is_line = self._follows(index)
        has_corridor = self._edges[index].corridor is not None and not is_line
        return is_line, has_corridor, self._is_backwards(index)

    @property
    def _way(self) -> list[tuple[float, float]]:
        """Where the robot is, and the nodes up to the one at which it stops next."""
        assert self.senses is not None
        nodes = self._nodes[: self._stop_index() + 1] if self._nodes else []
        places = [node.node_position for node in nodes if node.released]
        pose_map = self.senses.pose_map
        return [(pose_map.x, pose_map.y), *((place.x, place.y) for place in places if place)]

    def _lines_ahead(self, count: int) -> list[tuple[int, FloatArray]]:
        """Return the lines of so many edges with their sequenceIds; none if no zone needs them."""
        if not self.zones.is_coordinated or not self._nodes:
            return []
        lines = [(edge.sequence_id, line) for edge, line in self._lines(count) if edge.released]
        if lines:  # the present edge from the robot on
            number, line = lines[0]
            assert self.senses is not None
            here = self.senses.pose_map
            near = int(np.hypot(line[:, 0] - here.x, line[:, 1] - here.y).argmin())
            lines[0] = number, line[min(near, len(line) - 2) :]
        return lines

    # What it asks for; of 3.0

    def _ask(self, *, has_stopped: bool = False) -> None:
        """Ask for zones, ways and corridors, and do what becomes of lost permissions.

        Args:
            has_stopped: Whether the robot stands since it was told of its permissions.
        """
        if (senses := self.senses) is None:
            return
        may_ask = not self.is_manual and not self.simulated.is_intervened
        self.zones.look(
            self._way,
            senses.utc,
            self._lines_ahead(MOST_ASKED),
            self.order_id,
            is_standing=has_stopped,
            may_ask=may_ask,
        )
        self._corridor_error = None
        self._evacuate(senses.pose_map)
        keys = set()
        for index, edge in enumerate(self._edges[:CORRIDORS_AHEAD] if may_ask else ()):
            if edge.released and needs_release(edge) and not self._is_guided(index):
                keys.add(key := self._key_of(edge))
                self._look_at_corridor(key, index, senses)
        self.requests.keep(lambda key: key.kind != CORRIDOR or key in keys)
        if self._corridor not in keys:
            self._corridor = None
        if self._corridor_error is None:
            self._corridor_error = self._departure(senses.pose_map)

    def _look_at_corridor(self, key: RequestKey, index: int, senses: RobotSenses) -> None:
        is_begun = key == self._corridor
        request = self.requests.look(key, senses.utc, is_needed=True, is_begun=is_begun)
        if request is None:
            return
        if request.is_granted and index == 0:
            self._corridor = key
        elif request.is_lost:
            edge, line = self._lines(1)[0]
            here = senses.pose_map
            assert edge.corridor is not None
            if edge.corridor.release_loss_behavior == "STOP":
                text = f"the corridor of the edge '{key.name:.80}' is {request.status.lower()}"
                references = {"edgeId": key.name, "sequenceId": str(key.sequence_id)}
                self._corridor_error = ActiveError(OrderFault.RELEASE_LOST, text, references)
            elif np.hypot(line[:, 0] - here.x, line[:, 1] - here.y).min() <= ON_LINE:
                self.requests.give_up(key, senses.utc)
                self._corridor = None

    def _evacuate(self, pose_map: Pose) -> None:
        """Find the place to which the robot leaves a zone whose release is lost."""
        if not self.zones.is_evacuated:
            if self._refuge is not None:
                self._refuge = self._drive_error = None
            return
        if self._refuge is None:
            find, obstacle = self._ground.region_at, self._ground.obstacle_at
            here = find(pose_map.x, pose_map.y)
            place = self.zones.way_out(
                (pose_map.x, pose_map.y),
                lambda x, y: not obstacle(x, y) and (not here or find(x, y) == here),
            )
            if place is None:
                text = "there is no place beside the zone whose release is lost"
                self._corridor_error = ActiveError(OrderFault.RELEASE_LOST, text, {})
                return
            position = NodePosition(x=place[0], y=place[1], map_id=self._ground.map_id)
            self._refuge = Node(
                sequence_id=-1, released=True, actions=(), node_id="", node_position=position
            )

    def _departure(self, pose_map: Pose) -> ActiveError | None:
        """Return that the robot has left the corridor in which it was; None if it has not."""
        edge = self._edges[0] if self._edges and self._refuge is None else None
        if edge is None or edge.corridor is None or self.is_manual or self._follows(0):
            self._kept_in = {}
            return None
        key = self.order_id, edge.sequence_id
        if key not in self._kept_in:
            area = corridor_area(edge, self._lines(1)[0][1], self._radius)
            self._kept_in = dict([*self._kept_in.items(), (key, area)][-2:])
            self._has_been_inside = False
        middle = shapely.Point(pose_map.x, pose_map.y).buffer(max(self._radius - LEEWAY, 0.01))
        is_inside = bool(shapely.union_all([*self._kept_in.values()]).contains(middle))
        self._has_been_inside |= is_inside
        if is_inside or not self._has_been_inside:
            return None
        text = f"the robot has left the corridor of the edge '{edge.edge_id:.80}'"
        references = {"edgeId": edge.edge_id, "sequenceId": str(edge.sequence_id)}
        return ActiveError(OrderFault.OUTSIDE, text, references)

    def _key_of(self, edge: Edge) -> RequestKey:
        return RequestKey(CORRIDOR, edge.edge_id, self.order_id, edge.sequence_id)

    def _may_leave_line(self, edge: Edge) -> bool:
        request = self.requests.open.get(self._key_of(edge))
        return request is not None and request.is_granted

    @property
    def edge_requests(self) -> tuple[EdgeRequest, ...]:
        """The requests for corridors, for the fleet control."""
        return tuple(
            EdgeRequest(
                request_id=str(request.number),
                request_type=key.kind,
                edge_id=key.name,
                sequence_id=key.sequence_id,
                request_status=request.status,
            )
            for key, request in self.requests.open.items()
            if key.kind == CORRIDOR
        )

    def take_requests(self) -> Requests:
        """Return what is to be published or sent once; the next call does not."""
        requests, self._requests = self._requests, Requests()
        return requests

    # Its state

    @property
    def is_busy(self) -> bool:
        """Whether an order is being carried out, or waits for an update."""
        return bool(self._nodes) or any(not action.status.is_final for action in self._all)

    @property
    def waits_for_base(self) -> bool:
        """Whether the base is used up although the order goes on."""
        return bool(self._nodes) and not self._nodes[0].released

    @property
    def wants_base(self) -> bool:
        """Whether the base is nearly used up although the order goes on."""
        released = sum(node.released for node in self._nodes)
        return released <= 1 and len(self._nodes) > released

    @property
    def errors(self) -> list[ActiveError]:
        """All active errors."""
        driving = [self._drive_error] if self._drive_error else []
        rejected = [error for errors in self._rejections.values() for error in errors]
        own = [*rejected, *self._action_errors, *driving, *self.maps.errors, *self.zones.errors]
        corridor = [self._corridor_error] if self._corridor_error else []
        return [*own, *corridor, *self.simulated.errors]

    @property
    def operating_mode(self) -> str:
        """The operating mode, by its name inside the package."""
        return self.simulated.mode or ("MANUAL" if self.is_manual else DRIVES_ON[0])

    @property
    def node_states(self) -> tuple[NodeState, ...]:
        """Nodes that are not traversed yet."""
        return tuple(msgspec.convert(n, NodeState, from_attributes=True) for n in self._nodes)

    @property
    def edge_states(self) -> tuple[EdgeState, ...]:
        """Edges whose end is not reached yet."""
        return tuple(msgspec.convert(e, EdgeState, from_attributes=True) for e in self._edges)

    @property
    def action_states(self) -> tuple[ActionState, ...]:
        """Actions of the order."""
        return tuple(action.state() for action in self._all)

    @property
    def zone_action_states(self) -> tuple[ActionState, ...]:
        """Actions in zones."""
        return tuple(action.state() for action in self._zone_actions.runs)

    @property
    def instant_action_states(self) -> tuple[ActionState, ...]:
        """Instant actions."""
        return tuple(action.state() for action in self._instant.values())

    # Orders

    def _accept(self, order: DriveOrder) -> None:
        check_order(order, self._ground, self._offered, self._turn_rate, self._may_back)
        self._check_ways(order)
        if self.is_manual or self.simulated.is_lost:
            why = "does not know where it is" if self.simulated.is_lost else "is driven by hand"
            raise OrderRejectedError(OrderFault.NOT_AVAILABLE, f"the robot {why}")
        if order.order_id != self.order_id:
            self._check_new(order)
            self._begin(order)
        elif order.order_update_id < self.order_update_id:
            message = f"orderUpdateId is {order.order_update_id}; {self.order_update_id} is there"
            raise OrderRejectedError(OrderFault.OUTDATED, message)
        elif order.order_update_id == self.order_update_id:
            if order.content != self._content:
                message = "the order has this orderUpdateId, but other content"
                raise OrderRejectedError(OrderFault.SAME_UPDATE, message)
            return
        else:
            self._check_update(order)
            self._extend(order)
        self.order_update_id = order.order_update_id
        self._content = order.content
        self._rejections.pop(DriveOrder, None)

    def _check_ways(self, order: DriveOrder) -> None:
        """Refuse nodes to which no way leads on the map."""
        find = self._ground.region_at
        here = 0 if self.senses is None else find(self.senses.pose_map.x, self.senses.pose_map.y)
        for node in order.nodes:
            place = node.node_position
            assert place is not None
            region = find(place.x, place.y)
            if here and region not in (0, here):
                message = f"walls are all around ({place.x:g}, {place.y:g}): no way leads there"
                raise OrderRejectedError(OrderFault.NO_ROUTE, message, nodeId=node.node_id)

    def _check_new(self, order: DriveOrder) -> None:
        if self.is_busy or self._cancel is not None:
            raise OrderRejectedError(
                OrderFault.OTHER_ORDER, f"the order '{self.order_id}' is not done yet"
            )
        if order.order_id in self._used:
            raise OrderRejectedError(OrderFault.USED_ORDER, "this orderId was used before")
        if self.senses is None:
            raise OrderRejectedError(OrderFault.NOT_AVAILABLE, "the robot is not active yet")
        first = order.nodes[0]
        distance = _distance(first, self.senses.pose_map)
        if distance > _pass_radius(first):
            message = f"the robot is {distance:.1f} m from the first node"
            raise OrderRejectedError(OrderFault.START_FAR, message, nodeId=first.node_id)

    def _check_update(self, order: DriveOrder) -> None:
        if order.order_id == self._cancelled or self._cancel is not None:
            raise OrderRejectedError(OrderFault.CANCELLED, "the order was cancelled")
        base = [node for node in self._nodes if node.released]
        end = base[-1].key if base else self.last_node
        first = order.nodes[0]
        if first.key != end:
            message = f"it begins at node {first.key}; the base ends at {end}"
            raise OrderRejectedError(OrderFault.NO_CONTINUATION, message, nodeId=first.node_id)
        known = {action.action.action_id for action in self._all}
        kept = {action.action_id for action in first.actions}
        if not kept <= known:
            message = "the first node of an update must not have new actions"
            raise OrderRejectedError(OrderFault.NO_CONTINUATION, message, nodeId=first.node_id)
        horizon = {a.action_id for n in self._nodes if not n.released for a in n.actions}
        horizon |= {a.action_id for e in self._edges if not e.released for a in e.actions}
        if used := {a.action_id for a in order.actions} - kept & known - horizon:
            name = min(used)
            message = f"the actionId '{name}' is in use"
            raise OrderRejectedError(OrderFault.VALIDATION, message, actionId=name)
        if len(base) + len(order.nodes) > MOST_LEFT:
            raise OrderRejectedError(OrderFault.MEMORY, f"more than {MOST_LEFT} nodes are left")

    def _begin(self, order: DriveOrder) -> None:
        """Forget the order before, and stand at the first node of this one."""
        assert self.senses is not None
        self.tally.begin(self.senses.now)
        self.order_id = order.order_id
        _remember(self._used, order.order_id, None)
        self._actions.clear()
        if "clearInstantActions" not in self._offered:  # else they stay until that is asked for
            self._instant = {k: a for k, a in self._instant.items() if not a.status.is_final}
        self._action_errors.clear()
        self._reset_drive()
        self._nodes, self._edges = list(order.nodes), list(order.edges)
        self._add_actions(order.nodes, order.edges)
        self._traverse()

    def _extend(self, order: DriveOrder) -> None:
        """Put an update in the place of the horizon."""
        for part in (*self._nodes, *self._edges):
            if not part.released:
                self._actions.pop(part.sequence_id, None)
        was_done = not any(node.released for node in self._nodes)
        self._nodes = [node for node in self._nodes if node.released]
        self._edges = [edge for edge in self._edges if edge.released]
        self._nodes += order.nodes[1:]
        self._edges += order.edges
        self._add_actions(order.nodes[1:], order.edges)
        if was_done:
            self._trigger_edge()

    def _add_actions(self, nodes: Sequence[OrderPart], edges: Sequence[OrderPart]) -> None:
        for scope, parts in ((ActionScope.NODE, nodes), (ActionScope.EDGE, edges)):
            for part in parts:
                if part.actions:
                    runs = [RunningAction(action, scope) for action in part.actions]
                    self._actions[part.sequence_id] = runs

    def _drop_order(self, reason: str) -> None:
        for action in (*self._all, *self._zone_triggers):
            action.fail(reason)
        self._nodes, self._edges = [], []
        self._cancelled = self.order_id
        self._reset_drive()

    def _reset_drive(self) -> None:
        self._tries, self._is_stuck, self._retry_at = 0, False, 0.0
        self._drive_error = None

    # The way

    def _pass_nodes(self, before_map: Pose) -> None:
        """Traverse the nodes that the robot has passed since it was at a pose."""
        assert self.senses is not None
        while (leg := self.leg) is not None and len(leg.nodes) > 1:
            node = leg.nodes[0]
            if _distance_of_step(node, before_map, self.senses.pose_map) > _pass_radius(node):
                return
            self._traverse()

    def _stop_index(self) -> int:
        """Return the index of the next node at which the robot has to stop."""
        for index, node in enumerate(self._nodes):
            after = self._nodes[index + 1] if index + 1 < len(self._nodes) else None
            if after is None or not after.released:
                return index
            edge = self._edges[index + 1]
            if self._way_of(index + 1) != self._way_of(index) or keeps_heading(edge):
                return index
            halts = (*node.actions, *edge.actions)
            if any(not action.blocking_type.allows_driving for action in halts):
                return index
            position = node.node_position
            assert position is not None
            if position.theta is not None or 0.0 < position.deviation < PASS_RADIUS:
                return index
        return len(self._nodes) - 1

    def _traverse(self) -> None:
        """Leave the edge before the next node, and trigger the actions of node and next edge."""
        node = self._from = self._nodes.pop(0)
        if self._edges and self._edges[0].sequence_id < node.sequence_id:
            edge = self._edges.pop(0)
            for action in self._actions.get(edge.sequence_id, ()):
                action.fail("the edge ended")
        self.last_node = node.key
        self.driven = 0.0
        self._reset_drive()
        self._trigger(node.sequence_id)
        self._trigger_edge()

    def _trigger_edge(self) -> None:
        if self._edges and self._edges[0].released:
            self._trigger(self._edges[0].sequence_id)

    def _trigger(self, sequence_id: int) -> None:
        for action in self._actions.get(sequence_id, ()):
            action.is_triggered = True

    # Actions

    @property
    def _all(self) -> list[RunningAction]:
        return [action for key in sorted(self._actions) for action in self._actions[key]]

    @property
    def _due(self) -> list[RunningAction]:
        runs = (*self._all, *self._zone_actions.runs)
        return [run for run in runs if run.is_triggered and not run.status.is_final]

    @property
    def _zone_triggers(self) -> list[RunningAction]:
        """The waitForTrigger of zones, which end with the order."""
        return [run for run in self._zone_actions.runs if run.kind == "waitForTrigger"]

    @property
    def _is_blocked(self) -> bool:
        return any(not action.action.blocking_type.allows_driving for action in self._due)

    def _advance(self) -> None:
        """Let actions begin and end, as far as they can."""
        if self.senses is None:
            return
        now = self.senses.now
        for action in (*self._due, *self._instant.values()):
            if action.is_active:
                self._run(action, now)
        while (head := self._next_action()) is not None:
            self._start(head, now)
        failed = [action for action in self._all if action.status is ActionStatus.FAILED]
        for action in (*failed, *self._zone_actions.take_failed()):
            self._report_failure(action)

    def _next_action(self) -> RunningAction | None:
        """Return the action of the order that may begin now."""
        due = self._due
        waiting = [action for action in due if action.status is ActionStatus.WAITING]
        running = [action for action in due if action.status is not ActionStatus.WAITING]
        is_kept = self.is_paused or self.is_manual or self.simulated.is_intervened
        if not waiting or is_kept:
            return None
        if any(action.action.blocking_type.is_exclusive for action in running):
            return None
        head = waiting[0]
        return None if running and head.action.blocking_type.is_exclusive else head

    def _start(self, action: RunningAction, now: float) -> None:
        action.begin(now)
        load_id = action.action.parameter("loadId")
        if self.simulated.fails(action.kind):
            action.miss("simulated failure")
        elif action.kind == "pick" and self.load is not None:
            action.miss("the robot has a load")
        elif action.kind == "drop" and self.load is None:
            action.miss("the robot has no load")
        elif action.kind == "drop" and load_id not in (None, self.load and self.load.load_id):
            action.miss(f"the robot does not carry '{load_id}'")
        else:
            self._do(action)
        self._run(action, now)

    def _run(self, action: RunningAction, now: float) -> None:
        assert self.senses is not None
        is_over = action.is_over(now)
        if action.kind == "startCharging" and action.is_active:
            if self.senses.is_charging:
                action.finish("the battery is charged")
            elif self.senses.is_charging is None:
                action.miss("the robot has no battery")
            elif is_over:
                action.miss("no current: the robot does not stand at a charging station")
        elif action.kind == "cancelOrder" and action.is_active:
            if self.senses.is_standing:
                self._drop_order(CANCELLED)
                self._cancel = None
                action.finish()
        elif action.kind == "startPause" and action.is_active:
            if self.senses.is_standing:
                action.finish()
        elif is_over and action.is_active and action.kind not in OPEN_ENDED:
            self._handle_load(action)
            action.finish()

    def _handle_load(self, action: RunningAction) -> None:
        if action.kind == "pick":
            read = action.action.parameter
            self.load = VehicleLoad(load_id=read("loadId"), load_type=read("loadType"))
        elif action.kind == "drop":
            self.load = None

    def _report_failure(self, action: RunningAction) -> None:
        references = {"actionId": action.action.action_id, "orderId": self.order_id}
        report = ActiveError(OrderFault.ACTION, f"{action.kind}: {action.result}", references)
        if action.result not in (CANCELLED, BY_HAND) and report not in self._action_errors:
            self._action_errors.append(report)
            del self._action_errors[:-MOST_KEPT]

    def _initialise(self, action: RunningAction) -> None:
        read = action.action.parameter
        if read("mapId") != self._ground.map_id:
            action.fail(f"the map is '{self._ground.map_id}'")
            return
        pose_map = Pose(float(read("x")), float(read("y")), float(read("theta")))
        if obstacle := self._ground.obstacle_at(pose_map.x, pose_map.y):
            action.fail(f"the place is {obstacle}")
            return
        self._requests = replace(self._requests, initial_pose_map=pose_map)
        if not self.is_busy or not self._nodes:
            self.last_node = (read("lastNodeId", self.last_node[0]), self.last_node[1])
        action.finish()

    def _handle_map(self, run: RunningAction) -> None:
        """Enable or delete a map, or have one downloaded."""
        self.maps.errors.clear()
        read = run.action.parameter
        key = read("mapId"), read("mapVersion")
        if run.kind != "downloadMap":
            handle = self.maps.enable if run.kind == "enableMap" else self.maps.delete
            if problem := handle(*key):
                self._fail_map(run, OrderFault.INSTANT, problem)
            else:
                run.finish()
            return
        link, digest = read("mapDownloadLink"), read("mapHash", "")
        download = Download(run.action.action_id, link, digest)
        if self.maps.has(*key):
            text = f"the robot has the map '{key[0]:.80}' of version {key[1]:.40}: delete it first"
            self._fail_map(run, OrderFault.DUPLICATE_MAP, text)
        elif problem := self.maps.problem_of(key[0], download, self._count_downloads()):
            self._fail_map(run, OrderFault.INSTANT, problem)
        else:
            self._begin_fetching(run, download)

    def _begin_fetching(self, run: RunningAction, download: Download) -> None:
        run.status = ActionStatus.INITIALIZING
        downloads = (*self._requests.downloads, download)
        self._requests = replace(self._requests, downloads=downloads)

    def _download_zone_set(self, run: RunningAction) -> None:
        read = run.action.parameter
        name, link = read("zoneSetId"), read("zoneSetDownloadLink")
        download = Download(run.action.action_id, link, read("zoneSetHash", ""), is_map=False)
        if any(state.zone_set_id == name for state in self.zones.states):
            text = f"the zone set '{name:.80}' is known already"
            self._fail_zone_set(run, OrderRejectedError(OrderFault.ZONE_SET, text))
        elif download.problem:
            self._fail_zone_set(run, OrderRejectedError(OrderFault.INSTANT, download.problem))
        else:
            self._begin_fetching(run, download)

    def _end_zone_set(self, run: RunningAction, problem: str, zone_set: ZoneSet | None) -> None:
        name = run.action.parameter("zoneSetId")
        if zone_set is not None and zone_set.zone_set_id != name:
            problem = f"the file holds the zone set '{zone_set.zone_set_id:.80}'"
        if problem or zone_set is None:
            text = problem or "the file is empty"
            self._fail_zone_set(run, OrderRejectedError(OrderFault.ACTION, text))
            return
        try:
            self.zones.add(zone_set)
        except OrderRejectedError as error:
            self._fail_zone_set(run, error)
        else:
            self._rejections.pop(ZoneSetMessage, None)
            run.finish("not enabled")

    def _fail_zone_set(self, run: RunningAction, error: OrderRejectedError) -> None:
        run.fail(str(error))
        name, action_id = run.action.parameter("zoneSetId"), run.action.action_id
        more = {"zoneSetId": name, "actionId": action_id}
        self.reject(error, ZoneSetMessage, **more)

    def _count_downloads(self) -> int:
        runs = self._instant.values()
        return sum(run.kind == "downloadMap" and not run.status.is_final for run in runs)

    def _fail_map(self, run: RunningAction, fault: OrderFault, problem: str) -> None:
        run.fail(problem)
        if run.scope is not ActionScope.INSTANT:
            return  # an action of the order: its failure is reported
        read = run.action.parameter
        references = {key: read(key) for key in ("mapId", "mapVersion")}
        error = ActiveError(fault, problem, {"actionId": run.action.action_id} | references)
        self.maps.errors.append(error)
        self._answers.append(error)

    # Instant actions

    def _begin_instant(self, action: OrderAction, references: Mapping[str, str]) -> None:
        try:
            self._check_instant(action)
        except OrderRejectedError as error:
            self.reject(error, InstantActions, **references, actionId=action.action_id)

    def _check_instant(self, action: OrderAction) -> None:
        known = self._seen.get(action.action_id)
        if known is not None and known != action:
            raise OrderRejectedError(OrderFault.INSTANT, "another action has this actionId")
        if known is not None:
            return  # the message came twice
        if action.action_id in {each.action.action_id for each in self._all}:
            raise OrderRejectedError(OrderFault.INSTANT, "an action of the order has this actionId")
        _remember(self._seen, action.action_id, action)
        run = RunningAction(action, ActionScope.INSTANT)
        self._instant[action.action_id] = run
        ended = [key for key, each in self._instant.items() if each.status.is_final]
        for key in ended[: max(0, len(self._instant) - MOST_KEPT)]:  # the oldest
            del self._instant[key]
        problem = check_action(action, ActionScope.INSTANT, self._offered)
        is_kept = self.simulated.is_intervened and action.action_type not in SIMULATED
        if is_kept and action.action_type != "cancelOrder":
            problem = f"{action.action_type}: INTERVENED robots do cancelOrder only"
        if problem:
            run.fail(problem)
            raise OrderRejectedError(OrderFault.INSTANT, problem)
        run.begin(self.senses.now if self.senses is not None else 0.0)
        self._do(run)
        self._rejections.pop(InstantActions, None)

    def _do(self, run: RunningAction) -> None:
        """Do what takes no time."""
        match run.kind:
            case "cancelOrder":
                self._begin_cancel(run)
            case "startPause":
                self._pause(is_paused=True)
            case "stopPause":
                self._pause(is_paused=False)
                run.finish()
            case "stateRequest":
                self._requests = replace(self._requests, state=True)
                run.finish()
            case "factsheetRequest":
                self._requests = replace(self._requests, factsheet=True)
                run.finish()
            case "clearInstantActions":
                self._instant = {
                    key: each
                    for key, each in self._instant.items()
                    if each is run or not each.status.is_final
                }
                run.finish()
            case "clearZoneActions":
                self._zone_actions.clear()
                run.finish()
            case "trigger":
                self._trigger_waiting(run)
            case "retry" | "skipRetry":
                self._handle_retry(run)
            case "initPosition":
                self._initialise(run)
            case "logReport":
                reasons = (*self._requests.log_reasons, run.action.parameter("reason"))
                self._requests = replace(self._requests, log_reasons=reasons)
                run.finish(f"written to {LOG_FILE}")
            case "downloadMap" | "enableMap" | "deleteMap":
                self._handle_map(run)
            case "downloadZoneSet":
                self._download_zone_set(run)
            case "stopCharging":
                run.finish()
            case "enableZoneSet" | "deleteZoneSet":
                zones, name = self.zones, run.action.parameter("zoneSetId")
                handle = zones.enable if run.kind == "enableZoneSet" else zones.delete
                if problem := handle(name):
                    run.fail(problem)
                else:
                    self._rejections.pop(ZoneSetMessage, None)
                    run.finish()
            case kind if kind in SIMULATED:
                assert self.senses is not None
                given = {each.key: each.value for each in run.action.action_parameters}
                if problem := self.simulated.begin(kind, given, self.senses.now):
                    run.fail(problem)
                    raise OrderRejectedError(OrderFault.INSTANT, problem)
                run.finish("simulated")

    def _trigger_waiting(self, run: RunningAction) -> None:
        waiting = [each for each in self._due if each.kind == "waitForTrigger" and each.is_active]
        if not waiting:
            run.fail("nothing waits for a trigger")
            raise OrderRejectedError(OrderFault.INSTANT, run.result)
        for each in waiting:
            each.finish("triggered")
        run.finish()

    def _handle_retry(self, run: RunningAction) -> None:
        """Do an action again that failed, or let it fail for good."""
        name = run.action.parameter("actionId")
        retriable = (each for each in self._due if each.status is ActionStatus.RETRIABLE)
        found = next((each for each in retriable if each.action.action_id == name), None)
        if found is None or self.senses is None:
            run.fail(f"no action '{name:.80}' is RETRIABLE")
            raise OrderRejectedError(OrderFault.INSTANT, run.result)
        if run.kind == "skipRetry":
            found.fail(found.result)
        else:
            self._start(found, self.senses.now)
            found.pause(is_paused=self.is_paused)
        run.finish()

    def _begin_cancel(self, run: RunningAction) -> None:
        wanted = run.action.parameter("orderId", self.order_id)
        if not self.is_busy or self._cancel is not None or wanted != self.order_id:
            run.fail("there is no such order")
            raise OrderRejectedError(OrderFault.NO_ORDER, "there is no such order", orderId=wanted)
        self._cancel = run
        self.tally.given_up += 1
        for action in (*self._all, *self._zone_triggers):
            action.fail(CANCELLED)

    def _pause(self, *, is_paused: bool) -> None:
        self.is_paused = is_paused
        for action in self._due:
            action.pause(is_paused=is_paused)
        for each in self._instant.values():
            if each.kind == "startPause" and not is_paused and each.is_active:
                each.finish("paused no longer")


def _remember(known: dict[str, Any], name: str, value: Any) -> None:
    """Put a value under a name, and forget the oldest if there are too many."""
    known[name] = value
    if len(known) > MOST_USED:
        del known[next(iter(known))]


def _pass_radius(node: Node) -> float:
    assert node.node_position is not None
    return node.node_position.deviation or PASS_RADIUS


def _distance(node: Node, pose_map: Pose) -> float:
    position = node.node_position
    assert position is not None
    return math.hypot(position.x - pose_map.x, position.y - pose_map.y)


def _distance_of_step(node: Node, before_map: Pose, now_map: Pose) -> float:
    """Return the distance of a node from the line between two poses."""
    position = node.node_position
    assert position is not None
    dx, dy = now_map.x - before_map.x, now_map.y - before_map.y
    length = dx * dx + dy * dy
    ahead = (position.x - before_map.x) * dx + (position.y - before_map.y) * dy
    share = min(max(ahead / length, 0.0), 1.0) if length > 0.0 else 1.0
    x, y = before_map.x + share * dx, before_map.y + share * dy
    return math.hypot(position.x - x, position.y - y)

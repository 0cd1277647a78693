"""The messages of VDA 5050 as they are inside this package; `standard` has them by version.

Fields, units and meanings are the standard's: SI units, radians, the map's frame. Defaults hold
for what a version lacks or a message may leave out. What goes out leaves out optional fields
without a value.
"""

from __future__ import annotations

from datetime import datetime
from enum import StrEnum
from typing import Annotated, Any

import msgspec


class Incoming(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, rename="camel"
):
    """Sent by the fleet control."""


class Outgoing(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, rename="camel"):
    """Sent by a robot."""


class BlockingType(StrEnum):
    """Activities that an action allows meanwhile."""

    NONE = "NONE"  # driving and other actions
    SINGLE = "SINGLE"  # driving, but no other action; of 3.0
    SOFT = "SOFT"  # other actions, but no driving
    HARD = "HARD"  # neither

    @property
    def allows_driving(self) -> bool:
        """Whether the robot may drive meanwhile."""
        return self in (BlockingType.NONE, BlockingType.SINGLE)

    @property
    def is_exclusive(self) -> bool:
        """Whether no other action may run meanwhile."""
        return self in (BlockingType.SINGLE, BlockingType.HARD)


class ActionStatus(StrEnum):
    """How far an action is."""

    WAITING = "WAITING"
    INITIALIZING = "INITIALIZING"
    RUNNING = "RUNNING"
    PAUSED = "PAUSED"
    RETRIABLE = "RETRIABLE"  # failed, and waits for `retry` or `skipRetry`; of 3.0
    FINISHED = "FINISHED"
    FAILED = "FAILED"

    @property
    def is_final(self) -> bool:
        """Whether the action has ended."""
        return self in (ActionStatus.FINISHED, ActionStatus.FAILED)


# Incoming


class Parameter(Incoming, frozen=True):
    """A parameter of an action."""

    key: str
    value: Any


class OrderAction(Incoming, frozen=True):
    """Something to do besides driving."""

    action_type: str
    action_id: str = ""  # of zones: none
    blocking_type: BlockingType = BlockingType.HARD
    action_description: str = ""
    retriable: bool = False  # of 3.0
    action_parameters: tuple[Parameter, ...] = ()

    def parameter(self, key: str, default: Any = None) -> Any:
        """Return the value of a parameter, or `default` if it is not given."""
        found = [each.value for each in self.action_parameters if each.key == key]
        return found[0] if found else default


class Vertex(Incoming, frozen=True):
    """A place [m] in the map frame: also a corner of a zone."""

    x: float
    y: float


class Ellipse(Incoming, frozen=True):
    """How far [m] a robot may be from a node along two axes; of 3.0."""

    a: float
    b: float
    theta: float


class NodePosition(Vertex, frozen=True):
    """Where a node is, and how exactly it is to be met."""

    map_id: str
    theta: float | None = None
    allowed_deviation_xy: float | Ellipse = msgspec.field(default=0.0, name="allowedDeviationXY")
    allowed_deviation_theta: float | None = None
    map_description: str = ""

    @property
    def deviation(self) -> float:
        """The allowed deviation [m]: the circle inside an ellipse; 0 if none is given."""
        given = self.allowed_deviation_xy
        return min(given.a, given.b) if isinstance(given, Ellipse) else given


class OrderPart(Incoming, frozen=True):
    """A node or an edge of an order."""

    sequence_id: int
    released: bool
    actions: tuple[OrderAction, ...]


class Node(OrderPart, frozen=True):
    """A place on the way."""

    node_id: str
    node_position: NodePosition | None = None
    node_description: str = ""

    @property
    def key(self) -> tuple[str, int]:
        """Key that identifies a node within an order."""
        return self.node_id, self.sequence_id


class ControlPoint(Vertex, frozen=True):
    """A control point of a trajectory."""

    weight: float = 1.0
    orientation: float | None = None  # of 2.0


class Trajectory(Incoming, frozen=True):
    """A NURBS on which the robot is to drive; one without knots is a polyline."""

    control_points: tuple[ControlPoint, ...]
    knot_vector: tuple[float, ...] | None = None
    degree: int = 1


class Corridor(Incoming, frozen=True):
    """How far [m] a robot may be from the line of an edge."""

    left_width: float
    right_width: float
    corridor_ref_point: str = "KINEMATICCENTER"
    release_required: bool = False  # of 3.0
    release_loss_behavior: str = "STOP"  # of 3.0


class Edge(OrderPart, frozen=True):
    """The way from one node to the next."""

    edge_id: str
    start_node_id: str = ""  # empty in 3.0
    end_node_id: str = ""
    edge_description: str = ""
    max_speed: float | None = None
    max_height: float | None = None
    min_height: float | None = None
    orientation: float | None = None
    orientation_type: str = "TANGENTIAL"
    direction: str = ""
    rotation_allowed: bool | None = None
    reach_orientation_before_entering: bool = False  # of 3.0
    max_rotation_speed: float | None = None
    trajectory: Trajectory | None = None
    length: float | None = None
    corridor: Corridor | None = None


class Header(Incoming, frozen=True, kw_only=True):
    """Beginning of each message of the fleet control."""

    header_id: int = -1  # none was given
    timestamp: str = ""
    version: str
    manufacturer: str
    serial_number: str

    @property
    def references(self) -> dict[str, str]:
        """What an error about the message refers to."""
        return {"headerId": str(self.header_id)}


class DriveOrder(Header, frozen=True, kw_only=True):
    """A way with its actions, or the continuation of one."""

    order_id: str
    order_update_id: int
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    zone_set_id: str = ""
    order_description: str = ""

    @property
    def references(self) -> dict[str, str]:
        """What an error about the message refers to."""
        ids = {"orderId": self.order_id, "orderUpdateId": str(self.order_update_id)}
        return {"topic": "order", "headerId": str(self.header_id)} | ids

    @property
    def content(self) -> tuple[Any, ...]:
        """Content by which two messages are the same order."""
        return self.order_id, self.order_update_id, self.nodes, self.edges

    @property
    def actions(self) -> list[OrderAction]:
        """All actions, of nodes and edges, in their sequence."""
        parts = sorted((*self.nodes, *self.edges), key=lambda part: part.sequence_id)
        return [action for part in parts for action in part.actions]


class InstantActions(Header, frozen=True, kw_only=True):
    """Actions that are to be done at once."""

    actions: tuple[OrderAction, ...]

    @property
    def references(self) -> dict[str, str]:
        """What an error about the message refers to."""
        return {"topic": "instantActions", "headerId": str(self.header_id)}


class FleetZone(Incoming, frozen=True):
    """An area with a rule; of 3.0."""

    zone_id: str
    zone_type: str
    vertices: tuple[Vertex, ...]
    zone_descriptor: str = ""
    max_speed: float | None = None  # of SPEED_LIMIT
    penalty_factor: float | None = None  # of PENALTY
    release_loss_behavior: str = "STOP"  # of RELEASE
    priority_factor: float = 0.0  # of PRIORITY
    direction: float = 0.0  # [rad] of DIRECTED and BIDIRECTED
    limitation: str = "SOFT"  # likewise
    entry_actions: tuple[OrderAction, ...] = ()  # of ACTION
    during_actions: tuple[OrderAction, ...] = ()
    exit_actions: tuple[OrderAction, ...] = ()


class ZoneSet(Incoming, frozen=True):
    """The zones of a map; of 3.0."""

    map_id: str
    zone_set_id: str
    zones: tuple[FleetZone, ...]
    zone_set_descriptor: str = ""


class ZoneSetMessage(Header, frozen=True, kw_only=True):
    """Carries a zone set."""

    zone_set: ZoneSet


class GrantType(StrEnum):
    """Answer of the fleet control to a request."""

    GRANTED = "GRANTED"
    QUEUED = "QUEUED"
    REVOKED = "REVOKED"
    REJECTED = "REJECTED"


class Response(Incoming, frozen=True):
    """Answer to a request of the robot; of 3.0."""

    request_id: str
    grant_type: GrantType
    lease_expiry: Annotated[datetime, msgspec.Meta(tz=True)] | None = None


class Responses(Header, frozen=True, kw_only=True):
    """Carries answers."""

    responses: tuple[Response, ...]


# Outgoing


class PartState(Outgoing, frozen=True):
    """A node or an edge that is ahead."""

    sequence_id: int
    released: bool


class NodeState(PartState, frozen=True):
    """A node that is not traversed yet."""

    node_id: str


class EdgeState(PartState, frozen=True):
    """An edge whose end is not reached yet."""

    edge_id: str


class ActionState(Outgoing, frozen=True):
    """How far an action is, with its result."""

    action_id: str
    action_status: ActionStatus
    action_type: str | None = None
    action_description: str | None = None
    result_description: str | None = None


class AgvPosition(Outgoing, frozen=True):
    """Where the robot is."""

    x: float
    y: float
    theta: float
    map_id: str
    position_initialized: bool
    localization_score: float | None = None
    deviation_range: float | None = None


class AgvVelocity(Outgoing, frozen=True):
    """In the robot's frame."""

    vx: float
    vy: float
    omega: float


class VehicleLoad(Outgoing, frozen=True):
    """Load that the robot carries."""

    load_id: str | None = None
    load_type: str | None = None


class BatteryState(Outgoing, frozen=True):
    """Charge in percent."""

    battery_charge: float
    charging: bool
    battery_voltage: float | None = None


class Reference(Outgoing, frozen=True):
    """Subject of an error or an information."""

    reference_key: str
    reference_value: str


class Error(Outgoing, frozen=True):
    """Something that is wrong."""

    error_type: str
    error_level: str
    error_description: str | None = None
    error_references: tuple[Reference, ...] | None = None


class Info(Outgoing, frozen=True):
    """Something for people."""

    info_type: str
    info_level: str
    info_description: str | None = None
    info_references: tuple[Reference, ...] | None = None


class SafetyState(Outgoing, frozen=True):
    """Emergency stop and protective field."""

    e_stop: str
    field_violation: bool


class MapState(Outgoing, frozen=True):
    """A map that the robot has."""

    map_id: str
    map_version: str
    map_status: str


class ZoneSetState(Outgoing, frozen=True):
    """A zone set that the robot has."""

    zone_set_id: str
    map_id: str
    zone_set_status: str


class ZoneRequest(Outgoing, frozen=True):
    """Asks for the release of a zone, or for a way through it."""

    request_id: str
    request_type: str
    zone_id: str
    zone_set_id: str
    request_status: str
    trajectory: dict[str, Any] | None = None  # of REPLANNING


class EdgeRequest(Outgoing, frozen=True):
    """Asks for the use of an edge's corridor."""

    request_id: str
    request_type: str
    edge_id: str
    sequence_id: int
    request_status: str


class PathPoint(Outgoing, frozen=True):
    """A point of a path, and when the robot is to be there."""

    x: float
    y: float
    eta: str


class PlannedPath(Outgoing, frozen=True):
    """The way that a robot has planned, as a NURBS, and the nodes on it."""

    trajectory: dict[str, Any]
    traversed_nodes: tuple[str, ...]


class IntermediatePath(Outgoing, frozen=True):
    """The next piece of the way, with times."""

    polyline: tuple[PathPoint, ...]


class VehicleState(Outgoing, frozen=True):
    """All that a fleet control is to know of a robot; the header is put before it."""

    order_id: str
    order_update_id: int
    last_node_id: str
    last_node_sequence_id: int
    node_states: tuple[NodeState, ...]
    edge_states: tuple[EdgeState, ...]
    driving: bool
    action_states: tuple[ActionState, ...]
    instant_action_states: tuple[ActionState, ...]  # in 2.1 at the end of `action_states`
    battery_state: BatteryState
    operating_mode: str
    errors: tuple[Error, ...]
    safety_state: SafetyState
    information: tuple[Info, ...]
    maps: tuple[MapState, ...]
    loads: tuple[VehicleLoad, ...]
    paused: bool | None = None
    new_base_request: bool | None = None
    distance_since_last_node: float | None = None
    agv_position: AgvPosition | None = None
    velocity: AgvVelocity | None = None
    zone_sets: tuple[ZoneSetState, ...] = ()  # of 3.0
    zone_action_states: tuple[ActionState, ...] | None = None
    zone_requests: tuple[ZoneRequest, ...] | None = None  # empty if there is none
    edge_requests: tuple[EdgeRequest, ...] | None = None
    planned_path: PlannedPath | None = None
    intermediate_path: IntermediatePath | None = None

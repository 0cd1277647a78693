"""The zone sets of one robot, and when it may enter zones; of version 3.0."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import numpy as np
import shapely

from swarm_common.model.grid import KEEPOUT, Grid
from swarm_common.model.records import FloatArray, wrap_angle
from swarm_common.model.zones import DirectedZone
from swarm_vda5050.actions import ActionOffer, ActionScope, check_action
from swarm_vda5050.faults import ActiveError, OrderFault, OrderRejectedError
from swarm_vda5050.messages import (
    FleetZone,
    ZoneRequest,
    ZoneSet,
    ZoneSetState,
)
from swarm_vda5050.paths import planned_path
from swarm_vda5050.requests import RequestBook, RequestKey
from swarm_vda5050.ways import FARTHEST
from swarm_vda5050.zone_actions import ActionZone

BLOCKED, SPEED_LIMIT, PENALTY, RELEASE = "BLOCKED", "SPEED_LIMIT", "PENALTY", "RELEASE"
PRIORITY, LINE_GUIDED, COORDINATED = "PRIORITY", "LINE_GUIDED", "COORDINATED_REPLANNING"
ACTION, DIRECTED, BIDIRECTED = "ACTION", "DIRECTED", "BIDIRECTED"
SUPPORTED = (BLOCKED, SPEED_LIMIT, PENALTY, RELEASE, PRIORITY, LINE_GUIDED, COORDINATED, ACTION,
             DIRECTED, BIDIRECTED)  # fmt: skip
GUIDING = (LINE_GUIDED, COORDINATED)  # in which robots follow the lines of edges
ACCESS, REPLANNING = "ACCESS", "REPLANNING"  # requestTypes
# [rad] off the direction of a zone: up to where a way is free, and allowed, by its limitation.
# The moves of a plan are up to 0.464 rad apart: so one is always free, and two are allowed.
NEAR, BESIDE = 0.24, 0.47
OFF = {
    (DIRECTED, "SOFT"): (BESIDE, math.pi),
    (DIRECTED, "RESTRICTED"): (BESIDE, math.pi / 2),
    (DIRECTED, "STRICT"): (NEAR, BESIDE),
    (BIDIRECTED, "SOFT"): (NEAR, math.pi / 2),
    (BIDIRECTED, "RESTRICTED"): (NEAR, BESIDE),
}
MOST_SETS, MOST_ZONES = 50, 500
ROOM = 0.4  # [m] beside the body, and a zone that it has evacuated
BRAKING_ROOM = 0.5  # [m] before a speed limit at which the robot begins to brake
PLAIN = 0.02  # [m] by which a way that is asked for is simplified

Lines = Sequence[tuple[int, FloatArray]]  # of the next edges: sequenceId and (n, 2) [m] in map


@dataclass(slots=True)
class ZoneKeeper:
    """Zones that a robot knows.

    Attributes:
        map_id: Id of the only map.
        radius: [m] of the robot's body.
        offered: Actions that it offers, by actionType.
        book: Requests of the robot.
        errors: Errors that are active.
    """

    map_id: str
    radius: float
    offered: Mapping[str, ActionOffer] = field(default_factory=dict)
    book: RequestBook = field(default_factory=RequestBook)
    errors: list[ActiveError] = field(default_factory=list)
    _sets: dict[str, ZoneSet] = field(default_factory=dict)
    _enabled: str = ""
    _areas: dict[str, shapely.Geometry] = field(default_factory=dict)  # of the enabled set
    _zones: dict[str, FleetZone] = field(default_factory=dict)
    _on_way: set[str] = field(default_factory=set)  # COORDINATED ones that are being crossed
    _is_stopped: bool = False

    def add(self, zone_set: ZoneSet) -> None:
        """Keep another zone set, not enabled.

        Raises:
            OrderRejectedError: If it is known already, or makes no sense here.
        """
        name = zone_set.zone_set_id
        if name in self._sets:
            raise OrderRejectedError(
                OrderFault.ZONE_SET, f"the zone set '{name:.80}' is known already", zoneSetId=name
            )
        if zone_set.map_id != self.map_id:
            text = f"the map '{zone_set.map_id:.80}' is unknown; this robot has '{self.map_id}'"
            raise OrderRejectedError(OrderFault.UNKNOWN_MAP, text, zoneSetId=name)
        ids = {zone.zone_id for zone in zone_set.zones}
        if len(ids) < len(zone_set.zones) or len(ids) > MOST_ZONES or len(self._sets) >= MOST_SETS:
            text = f"zoneIds repeat, or there are more than {MOST_ZONES} zones or {MOST_SETS} sets"
            raise OrderRejectedError(OrderFault.VALIDATION, text, zoneSetId=name)
        for zone in zone_set.zones:
            _check(zone, name, self.offered)
        self._sets[name] = zone_set

    def enable(self, name: str) -> str:
        """Use a zone set in place of the one before; return what is wrong, if anything."""
        if name not in self._sets:
            return f"there is no zone set '{name:.80}'"
        self._enabled = name
        self.book.keep(lambda key: key.kind not in (ACCESS, REPLANNING))
        self._zones = {zone.zone_id: zone for zone in self._sets[name].zones}
        self._areas = {key: _polygon(zone) for key, zone in self._zones.items()}
        return ""

    @property
    def enabled(self) -> str:
        """Id of the zone set in use; empty for none."""
        return self._enabled

    @property
    def action_zones(self) -> dict[str, ActionZone]:
        """ACTION zones of the enabled set, by zoneId."""
        return {
            name: ActionZone(zone, self._areas[name])
            for name, zone in self._zones.items()
            if zone.zone_type == ACTION
        }

    def delete(self, name: str) -> str:
        """Forget a zone set that is not enabled; return what is wrong, if anything."""
        if name == self._enabled or name not in self._sets:
            return f"the zone set '{name:.80}' is enabled, or there is none"
        del self._sets[name]
        return ""

    def look(
        self,
        way: Sequence[tuple[float, float]],
        utc: datetime,
        lines: Lines = (),
        order_id: str = "",
        *,
        is_standing: bool = True,
        may_ask: bool = True,
    ) -> None:
        """Ask for the zones on the way, and see what became of requests.

        Args:
            way: (x, y) [m] in map: the robot, and the nodes that it drives to.
            utc: Time at which leases are compared with their end.
            lines: Lines of the edges of its base; may be left out without COORDINATED zones.
            order_id: Order to which they belong.
            is_standing: Whether the robot stands.
            may_ask: Whether the fleet control is in charge of the robot.
        """
        self.errors, self._is_stopped = [], False
        self._on_way.clear()
        if not self._zones:
            return
        body = shapely.Point(way[0]).buffer(self.radius)
        line = _line(way).buffer(self.radius)
        for name, zone in self._zones.items():
            area = self._areas[name]
            is_inside = bool(area.intersects(body))
            if zone.zone_type == BLOCKED and is_inside:
                self._stop(OrderFault.BLOCKED_ZONE, f"the robot is in the zone '{name:.80}'", name)
            elif zone.zone_type == RELEASE:
                is_needed = may_ask and (is_inside or bool(area.intersects(line)))
                self._look_at(name, is_needed, is_inside and may_ask, utc)
            elif zone.zone_type == COORDINATED:
                asked = lines if may_ask else ()
                self._look_at_way(name, way[0], is_inside, asked, order_id, utc, is_standing)

    def _look_at(self, name: str, is_needed: bool, is_begun: bool, utc: datetime) -> None:
        key = RequestKey(ACCESS, name)
        request = self.book.look(key, utc, is_needed=is_needed, is_begun=is_begun)
        is_lost = request is not None and request.is_lost
        if request is not None and is_lost and self._zones[name].release_loss_behavior == "STOP":
            text = f"the release of the zone '{name:.80}' is {request.status.lower()}"
            self._stop(OrderFault.RELEASE_LOST, text, name)

    def _look_at_way(
        self,
        name: str,
        here: tuple[float, float],
        is_inside: bool,
        lines: Lines,
        order_id: str,
        utc: datetime,
        is_standing: bool,
    ) -> None:
        """Ask for the way through a zone, as far as it is known, and drop what it replaces."""
        crossing = self._crossing(name, lines)
        last = crossing[-1] if crossing else None
        wanted = None if last is None else RequestKey(REPLANNING, name, order_id, last)
        for key in [key for key in self.book.open if key[:2] == (REPLANNING, name)]:
            is_on = bool(crossing) and key.order_id == order_id and key.sequence_id >= crossing[0]
            is_begun = is_inside and (is_on or not crossing)
            self.book.settle(key, utc, is_needed=is_on, is_begun=is_begun)
            kept = self.book.open.get(key)
            is_replaced = key != wanted and kept is not None and kept.is_asked
            if kept is not None and (is_replaced or (kept.is_lost and is_standing)):
                del self.book.open[key]  # what has stopped asks anew
        if is_inside:
            self._on_way.add(name)  # it stands, or follows what is granted
        if wanted is None:
            return
        found = self.book.look(
            wanted, utc, is_needed=True, is_begun=is_inside, way=lambda: _way_of(lines, last, here)
        )
        if found is not None and found.is_granted:
            self.book.keep(lambda key: key[:2] != (REPLANNING, name) or key == wanted)
        if crossing[0] <= self._granted_to(name, order_id):
            if lines[0][0] == crossing[0]:
                self._on_way.add(name)
        elif is_inside:
            text = f"the way through the zone '{name:.80}' is not granted"
            self._stop(OrderFault.DRIVING, text, name)

    def _crossing(self, name: str, lines: Lines) -> list[int]:
        """Return the sequenceIds of the edges on which the robot touches a zone."""
        area = self._areas[name]
        return [
            number
            for number, line in lines
            if area.intersects(shapely.LineString(line).buffer(self.radius))
        ]

    def _granted_to(self, name: str, order_id: str) -> int:
        """Return the sequenceId of the last edge that is granted through a zone; -1 for none."""
        return max(
            (
                key.sequence_id
                for key, request in self.book.open.items()
                if key[:3] == (REPLANNING, name, order_id) and request.is_granted
            ),
            default=-1,
        )

    def _stop(self, fault: OrderFault, text: str, name: str) -> None:
        self._is_stopped = True
        references = {"zoneId": name, "zoneSetId": self._enabled}
        self.errors.append(ActiveError(fault, text, references))

    def reach(
        self, way: Sequence[tuple[float, float]], lines: Lines = (), order_id: str = ""
    ) -> int:
        """Return how many parts of a way may be driven before a zone that is not released.

        Args:
            way: (x, y) [m] in map: the robot, and the nodes that it drives to.
            lines: Lines of its parts; may be left out without COORDINATED zones.
            order_id: Order to which they belong.
        """
        if self._is_stopped:
            return 0
        for name, zone in self._zones.items() if lines else ():
            if zone.zone_type == COORDINATED:
                granted = self._granted_to(name, order_id)
                barred = [number for number in self._crossing(name, lines) if number > granted]
                if barred:
                    first = [number for number, _ in lines].index(barred[0])
                    way, lines = way[: first + 1], lines[:first]
        barred_areas = [self._areas[name] for name in self._barred]
        if not barred_areas:
            return len(way) - 1
        area, body = shapely.union_all(barred_areas), shapely.Point(way[0]).buffer(self.radius)
        if area.intersects(body):
            return 0
        for index in range(len(way) - 1):
            if area.intersects(_line(way[index : index + 2]).buffer(self.radius)):
                return index
        return len(way) - 1

    @property
    def is_stopped(self) -> bool:
        """Whether the robot is in a zone in which it must not drive."""
        return self._is_stopped

    @property
    def is_coordinated(self) -> bool:
        """Whether there are zones through which ways are granted."""
        return any(zone.zone_type == COORDINATED for zone in self._zones.values())

    @property
    def _barred(self) -> list[str]:
        return [
            name
            for name, zone in self._zones.items()
            if zone.zone_type == RELEASE and not self._may_be_in(name)
        ]

    def _may_be_in(self, name: str) -> bool:
        request = self.book.open.get(RequestKey(ACCESS, name))
        if request is None:
            return False
        goes_on = self._zones[name].release_loss_behavior == "CONTINUE"
        return request.is_granted or (request.is_lost and goes_on)

    @property
    def _evacuated(self) -> list[str]:
        """Zones in which the robot has lost its release, and that it has to leave."""
        return [
            key.name
            for key, request in self.book.open.items()
            if key.kind == ACCESS and request.is_lost
            and self._zones[key.name].release_loss_behavior == "EVACUATE"
        ]  # fmt: skip

    @property
    def is_evacuated(self) -> bool:
        """Whether the robot has to leave a zone."""
        return bool(self._evacuated)

    def way_out(
        self, here: tuple[float, float], is_open: Callable[[float, float], bool]
    ) -> tuple[float, float] | None:
        """Return the nearest place [m] in map beside the zones that the robot has to leave, if any.

        Args:
            here: Place [m] of the robot in map.
            is_open: Whether it can drive to a place x, y [m].
        """
        lost = shapely.union_all([self._areas[name] for name in self._evacuated])
        closed = [self._areas[name] for name, cost in self.costs.items() if cost == KEEPOUT]
        area = shapely.union_all(closed).buffer(self.radius + 0.5 * ROOM)
        ring = lost.buffer(self.radius + ROOM).boundary
        places = shapely.get_coordinates(shapely.segmentize(ring, ROOM)).tolist()
        found = [(x, y) for x, y in places if not shapely.contains_xy(area, x, y) and is_open(x, y)]
        return min(found, key=lambda place: math.dist(place, here), default=None)

    def limit_at(self, x: float, y: float) -> float:
        """Return the speed limit [m/s] at a place [m] in map; inf without one."""
        near = shapely.Point(x, y).buffer(self.radius + BRAKING_ROOM)
        return min(
            (
                zone.max_speed or math.inf
                for name, zone in self._zones.items()
                if zone.zone_type == SPEED_LIMIT and self._areas[name].intersects(near)
            ),
            default=math.inf,
        )

    @property
    def has_lines(self) -> bool:
        """Whether there are zones in which robots follow the lines of edges."""
        return any(zone.zone_type in GUIDING for zone in self._zones.values())

    def guides(self, line_map: FloatArray) -> bool:
        """Return whether a robot on a line (n, 2) [m] touches a zone in which it is followed."""
        line = shapely.LineString(line_map).buffer(self.radius)
        return any(
            zone.zone_type in GUIDING and self._areas[name].intersects(line)
            for name, zone in self._zones.items()
        )

    @property
    def costs(self) -> dict[str, int]:
        """Value in a keepout mask by zone: `KEEPOUT` where the robot must not be, less for more.

        A value below 0 is a preference: all places outside cost so much more.
        """
        values = dict.fromkeys(self._barred, KEEPOUT)
        for name, zone in self._zones.items():
            is_closed = zone.zone_type == COORDINATED and name not in self._on_way
            if zone.zone_type == BLOCKED or is_closed:
                values[name] = KEEPOUT
            elif zone.zone_type == PENALTY and zone.penalty_factor:
                values[name] = math.ceil((KEEPOUT - 1) * zone.penalty_factor)
            elif zone.zone_type == PRIORITY and zone.priority_factor:
                values[name] = -math.ceil((KEEPOUT - 1) * zone.priority_factor)
        return values

    @property
    def directed(self) -> tuple[DirectedZone, ...]:
        """Zones with a direction, for the navigator."""
        return tuple(
            DirectedZone(
                tuple((corner.x, corner.y) for corner in zone.vertices),
                wrap_angle(zone.direction),
                *OFF[zone.zone_type, zone.limitation],
                is_two_way=zone.zone_type == BIDIRECTED,
            )
            for zone in self._zones.values()
            if zone.zone_type in (DIRECTED, BIDIRECTED)
        )

    def mask(self, grid: Grid, corridors: Sequence[shapely.Geometry]) -> Grid:
        """Return a keepout mask with the cells of a map.

        Args:
            corridors: Outside of which the robot must not be; none for anywhere.
        """
        size = grid.resolution
        x = grid.origin_x + (np.arange(grid.width) + 0.5) * size
        y = grid.origin_y + (np.arange(grid.height) + 0.5) * size
        places = np.meshgrid(x, y)
        costs = self.costs
        outside = -min([0, *costs.values()])
        values = np.full(grid.cells.shape, outside, np.int8)
        for name, cost in sorted(costs.items(), key=lambda pair: pair[1]):  # preferences first
            inside = _within(self._areas[name].buffer(0.5 * math.sqrt(2.0) * size), places)
            if cost < 0:
                values[inside] = np.minimum(values[inside], outside + cost)
            else:
                values[inside] = np.maximum(values[inside], cost)
        if corridors:
            values[~_within(shapely.union_all(corridors), places)] = KEEPOUT
        return Grid(values, size, grid.origin_x, grid.origin_y)

    @property
    def states(self) -> tuple[ZoneSetState, ...]:
        """The zone sets, for the fleet control."""
        return tuple(
            ZoneSetState(
                zone_set_id=name,
                map_id=self.map_id,
                zone_set_status="ENABLED" if name == self._enabled else "DISABLED",
            )
            for name in self._sets
        )

    @property
    def requests(self) -> tuple[ZoneRequest, ...]:
        """The requests for zones, for the fleet control."""
        asked = [each for each in self.book.open.items() if each[0].kind in (ACCESS, REPLANNING)]
        return tuple(
            ZoneRequest(
                request_id=str(request.number),
                request_type=key.kind,
                zone_id=key.name,
                zone_set_id=self._enabled,
                request_status=request.status,
                trajectory=None if request.way is None else _nurbs(request.way),
            )
            for key, request in asked
        )


def _way_of(lines: Lines, last: int | None, here: tuple[float, float]) -> FloatArray:
    """Return the way (n, 2) [m] in map from the robot to the end of an edge."""
    points = np.vstack([line for number, line in lines if last is None or number <= last])
    near = int(np.hypot(*(lines[0][1] - here).T).argmin())
    way = np.vstack((np.array([here]), points[near:]))
    plain: FloatArray = shapely.get_coordinates(shapely.LineString(way).simplify(PLAIN))
    return plain if len(plain) > 1 else way


def _nurbs(way: FloatArray) -> dict[str, Any]:
    path = planned_path(way, ())
    assert path is not None
    return path.trajectory


def _check(zone: FleetZone, zone_set: str, offered: Mapping[str, ActionOffer]) -> None:
    where = {"zoneId": zone.zone_id, "zoneSetId": zone_set}
    if zone.zone_type == BIDIRECTED and zone.limitation == "STRICT":
        text = "limitation is STRICT; a zone of two directions is SOFT or RESTRICTED"
        raise OrderRejectedError(OrderFault.VALIDATION, text, **where)
    for action in (*zone.entry_actions, *zone.during_actions, *zone.exit_actions):
        if problem := check_action(action, ActionScope.ZONE, offered):
            kind = action.action_type
            raise OrderRejectedError(OrderFault.UNSUPPORTED, problem, parameter=kind, **where)
    numbers = [value for corner in zone.vertices for value in (corner.x, corner.y)]
    is_shape = len(zone.vertices) >= 3 and all(abs(number) <= FARTHEST for number in numbers)
    if not is_shape or not _polygon(zone).is_valid or _polygon(zone).area == 0.0:
        raise OrderRejectedError(OrderFault.VALIDATION, "the vertices are no polygon", **where)
    speed, penalty, priority = zone.max_speed, zone.penalty_factor, zone.priority_factor
    if zone.zone_type == SPEED_LIMIT and not (speed is not None and 0.0 < speed < math.inf):
        text = f"maximumSpeed is {speed}; it must be positive"
        raise OrderRejectedError(OrderFault.VALIDATION, text, **where)
    if zone.zone_type == PENALTY and not (penalty is not None and 0.0 <= penalty <= 1.0):
        text = f"penaltyFactor is {penalty}; expected 0 to 1"
        raise OrderRejectedError(OrderFault.VALIDATION, text, **where)
    if zone.zone_type == PRIORITY and not 0.0 <= priority <= 1.0:
        text = f"priorityFactor is {priority}; expected 0 to 1"
        raise OrderRejectedError(OrderFault.VALIDATION, text, **where)


def _polygon(zone: FleetZone) -> shapely.Polygon:
    return shapely.Polygon([(corner.x, corner.y) for corner in zone.vertices])


def _line(way: Sequence[tuple[float, float]]) -> shapely.Geometry:
    return shapely.LineString(way) if len(way) > 1 else shapely.Point(way[0])


def _within(area: shapely.Geometry, places: Sequence[FloatArray]) -> np.ndarray:
    shapely.prepare(area)
    return np.asarray(shapely.contains_xy(area, *places))

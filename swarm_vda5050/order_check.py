"""Whether an order makes sense in itself, before anybody asks if it fits the robot's state."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy import ndimage

from swarm_common.model.grid import KEEPOUT, OCCUPIED, Grid
from swarm_common.model.records import FloatArray
from swarm_vda5050.actions import OFFERED, ActionOffer, ActionScope, check_action
from swarm_vda5050.faults import OrderFault, OrderRejectedError
from swarm_vda5050.messages import DriveOrder, Edge, Node, OrderAction
from swarm_vda5050.ways import (
    FARTHEST,
    LONGEST,
    direction_problem,
    heading_problem,
    line_of,
    problem_of,
)

STOP_RADIUS = 0.35  # [m] around a node at which the robot stops: the goal checker's, and its play
MOST_NODES = 1000  # of one message
MOST_ACTIONS = 100  # of one node or edge


def anywhere(x: float, y: float) -> str:
    """Return that robots may be at every place."""
    return ""


def in_none(x: float, y: float) -> int:
    """Return that no place belongs to a known region."""
    return 0


def regions_of(grid: Grid, room: float) -> Callable[[float, float], int]:
    """Return what tells the region of a place: floor that walls and keepout zones part from others.

    Args:
        room: [m] that a robot needs beside it.

    Returns:
        Number of the region of a place x, y [m] in map; 0 where a robot hardly fits.
    """
    closed = grid.cells == OCCUPIED
    if grid.keepout is not None:
        closed |= grid.keepout == KEEPOUT
    cells = max(0.0, room / grid.resolution - 0.5)  # between centres, and one to spare
    clear = ndimage.distance_transform_edt(np.pad(~closed, 1))[1:-1, 1:-1] > cells
    regions, _ = ndimage.label(clear, np.ones((3, 3)))
    return lambda x, y: int(regions[grid.cell_of(x, y)]) if grid.contains(x, y) else 0


@dataclass(frozen=True, slots=True)
class DrivingArea:
    """Where robots may drive."""

    map_id: str  # id of the only map
    # returns what is in the way at a place x, y [m]; empty if it is free
    obstacle_at: Callable[[float, float], str] = anywhere
    # returns a number of the floor that hangs together around a place x, y [m]; 0 if unknown
    region_at: Callable[[float, float], int] = in_none
    # the map
    grid: Grid = field(default_factory=lambda: Grid(np.zeros((1, 1), np.int8), 1.0, 0.0, 0.0))


def check_order(
    order: DriveOrder,
    ground: DrivingArea,
    offered: Mapping[str, ActionOffer] = OFFERED["2.1"],
    turn_rate: float = math.inf,
    may_back: bool = True,
) -> None:
    """Check structure, places and actions of an order or an update.

    Args:
        offered: Actions of the version, by actionType.
        turn_rate: [rad/s] that the robot turns at most.
        may_back: Whether it drives backwards, too.

    Raises:
        RejectedError: For the first thing that is wrong.
    """
    _check_sequence(order)
    for node in order.nodes:
        _check_node(node, ground)
        _check_actions(node.actions, ActionScope.NODE, offered, nodeId=node.node_id)
    line: FloatArray | None = None
    for edge, (start, end) in zip(order.edges, pairwise(order.nodes), strict=True):
        before, line = line, _check_edge(edge, start, end, turn_rate, may_back)
        if problem := direction_problem(edge, line, before):
            _refuse(edge, "direction", problem)
        _check_actions(edge.actions, ActionScope.EDGE, offered, edgeId=edge.edge_id)
    counts = Counter(action.action_id for action in order.actions)
    for action_id, count in counts.items():
        if count > 1:
            message = f"the actionId '{action_id}' occurs {count} times"
            raise OrderRejectedError(OrderFault.VALIDATION, message, actionId=action_id)


def _check_sequence(order: DriveOrder) -> None:
    nodes, edges = order.nodes, order.edges
    if not 1 <= len(nodes) <= MOST_NODES:
        raise _invalid(f"{len(nodes)} nodes; expected 1 to {MOST_NODES}")
    if len(edges) != len(nodes) - 1:
        raise _invalid(f"{len(edges)} edges for {len(nodes)} nodes; expected {len(nodes) - 1}")
    first = nodes[0].sequence_id
    if first % 2:
        raise _invalid(f"the first node has the sequenceId {first}; expected an even number")
    for index, node in enumerate(nodes):
        if node.sequence_id != first + 2 * index:
            expected = first + 2 * index
            raise _invalid(
                f"the sequenceId is {node.sequence_id}; expected {expected}", nodeId=node.node_id
            )
    for index, edge in enumerate(edges):
        start, end = nodes[index], nodes[index + 1]
        if edge.sequence_id != start.sequence_id + 1:
            raise _invalid(
                f"the sequenceId is {edge.sequence_id}; expected {start.sequence_id + 1}",
                edgeId=edge.edge_id,
            )
        ends = edge.start_node_id or start.node_id, edge.end_node_id or end.node_id
        if ends != (start.node_id, end.node_id):
            raise _invalid(
                f"it leads from '{edge.start_node_id}' to '{edge.end_node_id}'; the nodes beside"
                f" it are '{start.node_id}' and '{end.node_id}'",
                edgeId=edge.edge_id,
            )
        if edge.released != end.released:
            raise _invalid("edge and end node must be released together", edgeId=edge.edge_id)
    if not nodes[0].released:
        raise _invalid("the first node must be released", nodeId=nodes[0].node_id)
    for before, node in pairwise(nodes):
        if node.released and not before.released:
            raise _invalid("a released node follows one that is not", nodeId=node.node_id)


def _check_node(node: Node, ground: DrivingArea) -> None:
    position = node.node_position
    if position is None:
        raise OrderRejectedError(
            OrderFault.UNSUPPORTED, "nodePosition is required by this robot", nodeId=node.node_id
        )
    if position.map_id != ground.map_id:
        raise OrderRejectedError(
            OrderFault.UNKNOWN_MAP,
            f"the map '{position.map_id}' is unknown; this robot has '{ground.map_id}'",
            nodeId=node.node_id,
            mapId=position.map_id,
        )
    if obstacle := ground.obstacle_at(position.x, position.y):
        place = f"({position.x:g}, {position.y:g})"
        raise OrderRejectedError(OrderFault.NO_ROUTE, f"{place} is {obstacle}", nodeId=node.node_id)


def _check_edge(edge: Edge, start: Node, end: Node, turn_rate: float, may_back: bool) -> FloatArray:
    """Return the line (n, 2) [m] of a sound edge in map."""
    corridor = edge.corridor
    unsupported = {
        "maxRotationSpeed": (edge.max_rotation_speed or math.inf) < turn_rate,
    }
    for name, is_asked in unsupported.items():
        if is_asked:
            _refuse(edge, name, f"{name} is not supported")
    if edge.max_speed is not None and not 0.0 < edge.max_speed < math.inf:
        raise _invalid(f"maxSpeed is {edge.max_speed}; it must be positive", edgeId=edge.edge_id)
    if corridor is not None:
        widths = corridor.left_width, corridor.right_width
        if not all(0.0 <= width <= FARTHEST for width in widths):
            raise _invalid(f"the corridor's widths are {widths}", edgeId=edge.edge_id)
    a, b = start.node_position, end.node_position
    assert a is not None
    assert b is not None
    if not (length := math.hypot(b.x - a.x, b.y - a.y)) <= LONGEST:
        raise _invalid(f"{length:g} m of way; at most {LONGEST:g} m are taken", edgeId=edge.edge_id)
    if edge.trajectory is not None:
        _check_trajectory(edge, start, end)
    line = line_of(edge, a, b)
    if problem := heading_problem(edge, line, may_back=may_back):
        _refuse(edge, "orientation", problem)
    return line


def _refuse(edge: Edge, name: str, message: str) -> None:
    raise OrderRejectedError(OrderFault.UNSUPPORTED, message, edgeId=edge.edge_id, parameter=name)


def _check_trajectory(edge: Edge, start: Node, end: Node) -> None:
    assert edge.trajectory is not None
    if problem := problem_of(edge.trajectory):
        raise _invalid(f"the trajectory has {problem}", edgeId=edge.edge_id)
    assert start.node_position is not None
    assert end.node_position is not None
    line = line_of(edge, start.node_position, end.node_position)
    for node, (x, y) in ((start, line[0]), (end, line[-1])):
        assert node.node_position is not None
        gap = math.hypot(node.node_position.x - x, node.node_position.y - y)
        if not gap <= max(node.node_position.deviation, STOP_RADIUS):
            raise _invalid(
                f"the trajectory is {gap:.2f} m from its node",
                edgeId=edge.edge_id,
                nodeId=node.node_id,
            )


def _check_actions(
    actions: tuple[OrderAction, ...],
    scope: ActionScope,
    offered: Mapping[str, ActionOffer],
    **where: object,
) -> None:
    if len(actions) > MOST_ACTIONS:
        raise _invalid(f"{len(actions)} actions; at most {MOST_ACTIONS} are taken", **where)
    for action in actions:
        if problem := check_action(action, scope, offered):
            names = ", ".join(sorted(offered))
            hint = "" if action.action_type in offered else f"; offered are {names}"
            raise OrderRejectedError(
                OrderFault.UNKNOWN_ACTION,
                f"{problem}{hint}",
                actionId=action.action_id,
                actionType=action.action_type,
                **where,
            )


def _invalid(message: str, **references: object) -> OrderRejectedError:
    return OrderRejectedError(OrderFault.VALIDATION, message, **references)

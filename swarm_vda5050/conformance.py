"""A verdict on the fleet control: which rules of the standard its messages kept, and which not."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any, NamedTuple

from swarm_vda5050.faults import ActiveError, OrderFault
from swarm_vda5050.messages import DriveOrder, Header, InstantActions, Node
from swarm_vda5050.reading import time_of
from swarm_vda5050.simulated_faults import SIMULATED
from swarm_vda5050.standard import VERSIONS

EXACT = 0.05  # [m] that a node may be off its place in the layout
LONGEST = 2000  # characters of a message that the report quotes
PLAIN = re.compile(r"[A-Za-z0-9_.:-]*")  # ids, as the standard recommends them
NEW, UPDATE = "new order", "order update"
ORDERS, ACTIONS = (NEW, UPDATE), ("instantActions",)
ALL = (*ORDERS, *ACTIONS, "zoneSet", "responses")


class ProtocolRule(NamedTuple):
    """A rule for fleet controls."""

    text: str
    of: tuple[str, ...]  # kinds of messages that it is about
    is_duty: bool = True  # whether the standard demands it, not only recommends it
    action: str = ""  # the instant action that it is about, if about one


RULES = {
    "schema": ProtocolRule("fields, types and bounds are those of the version's schema", ALL),
    "version": ProtocolRule("the header has the version that the robot speaks", ALL),
    "retained": ProtocolRule("what a robot is to do is not retained by the broker", ALL),
    "headerId": ProtocolRule("headerIds of a topic ascend", ALL),
    "timestamp": ProtocolRule("timestamps are in UTC and never go back", ALL),
    "ids": ProtocolRule("ids are of the characters A-Z a-z 0-9 _ - . :", ORDERS, is_duty=False),
    "structure": ProtocolRule(
        "nodes and edges alternate, sequenceIds ascend, base before horizon", ORDERS
    ),
    "first update": ProtocolRule(
        "a new order has the orderUpdateId 0 and begins at sequenceId 0", (NEW,)
    ),
    "one order": ProtocolRule("no new order is sent while another is active", (NEW,)),
    "orderId": ProtocolRule("no orderId is used twice", (NEW,)),
    "start": ProtocolRule("a new order begins where the robot is", (NEW,)),
    "orderUpdateId": ProtocolRule(
        "orderUpdateIds ascend, and the same one has the same content", (UPDATE,)
    ),
    "stitching": ProtocolRule("an update begins at the last node of the base", (UPDATE,)),
    "base": ProtocolRule("the stitching node is sent again unchanged", (UPDATE,)),
    "horizon": ProtocolRule(
        "an update comes before the robot waits at the end of its base", (UPDATE,), is_duty=False
    ),
    "after cancel": ProtocolRule("a cancelled order is not updated", (UPDATE,)),
    "map": ProtocolRule("nodes are on a map that the robot has", ORDERS),
    "reachable": ProtocolRule("nodes are where robots may be", ORDERS),
    "layout": ProtocolRule("edges and places of nodes are those of the layout", ORDERS),
    "actions": ProtocolRule("actions and parameters are those of the factsheet", ORDERS),
    "optional fields": ProtocolRule("optional fields are those of the factsheet", ORDERS),
    "available": ProtocolRule("orders are sent to robots that take them", ORDERS),
    "instant actions": ProtocolRule(
        "instant actions are those of the factsheet, and about what there is", ACTIONS
    ),
    "maps": ProtocolRule("no map is downloaded that the robot has", ACTIONS, action="downloadMap"),
    "cancel": ProtocolRule(
        "cancelOrder names an order that is active", ACTIONS, action="cancelOrder"
    ),
    "zone sets": ProtocolRule("zone sets make sense, and no zoneSetId is used twice", ("zoneSet",)),
    "responses": ProtocolRule(
        "responses are to requests of the robot, and REVOKED is what was granted", ("responses",)
    ),
}
OF_TOPIC = {"zoneSet": "zone sets", "responses": "responses"}  # likewise, whatever the fault
OF_FAULT = {  # the rule that a message breaks which is answered by a fault
    OrderFault.VALIDATION: "structure",
    OrderFault.UNSUPPORTED: "optional fields",
    OrderFault.UNKNOWN_ACTION: "actions",
    OrderFault.OUTDATED: "orderUpdateId",
    OrderFault.SAME_UPDATE: "orderUpdateId",
    OrderFault.NO_CONTINUATION: "stitching",
    OrderFault.MEMORY: "structure",
    OrderFault.CANCELLED: "after cancel",
    OrderFault.OTHER_ORDER: "one order",
    OrderFault.USED_ORDER: "orderId",
    OrderFault.START_FAR: "start",
    OrderFault.NO_ROUTE: "reachable",
    OrderFault.UNKNOWN_MAP: "map",
    OrderFault.NOT_AVAILABLE: "available",
    OrderFault.NO_ORDER: "cancel",
    OrderFault.DUPLICATE_MAP: "maps",
    OrderFault.INSTANT: "instant actions",
    OrderFault.ZONE_SET: "zone sets",
}


class Heard(NamedTuple):
    """A message of the fleet control, and how it was answered."""

    robot: str
    topic: str
    payload: bytes
    is_retained: bool
    message: Header | None  # None if it could not be read, or was not
    errors: Sequence[ActiveError]  # that it was answered with
    forgiven: Sequence[str]  # what was wrong, and taken
    has_waited: bool = False  # whether the robot stood at the end of its base, with a horizon


@dataclass(slots=True)
class _Count:
    """How often a rule was seen, kept, broken and forgiven."""

    kept: int = 0
    broken: int = 0
    forgiven: int = 0
    first: dict[str, str] | None = None  # message that broke it


@dataclass(slots=True)
class _Memory:
    """What is known of the messages to one robot."""

    header_ids: dict[str, tuple[int, bytes]] = field(default_factory=dict)  # by topic
    times: dict[str, datetime] = field(default_factory=dict)
    order_id: str = ""  # of the latest order
    end: Node | None = None  # of its base


class Conformance:
    """Counts rules over all messages of a run."""

    def __init__(
        self,
        version: str,
        note: Callable[[str], None],
        edges: Collection[tuple[str, str]] | None = None,
        places: Mapping[str, tuple[float, float]] | None = None,
    ) -> None:
        """Begin with nothing heard.

        Args:
            version: Like `2.1`.
            note: Called with what the user is to read.
            edges: Ids of start and end node of the layout's edges; None without a layout.
            places: Where the layout's nodes are, x and y [m] in map.
        """
        self._version, self._note, self._edges = version, note, edges
        self._places = places or {}
        self._counts = {name: _Count() for name in RULES}
        self._memories: dict[str, _Memory] = {}
        self._messages = 0

    @property
    def broken(self) -> list[str]:
        """Rules that were broken although the standard demands them."""
        return [
            name for name, count in self._counts.items() if count.broken and RULES[name].is_duty
        ]

    def judge(self, heard: Heard) -> None:
        """Count a message; faults on demand are a tester's, not the fleet control's."""
        wanted = _wanted(heard.message)
        if wanted and wanted <= SIMULATED.keys():
            return
        self._messages += 1
        memory = self._memories.setdefault(heard.robot, _Memory())
        problems = dict(self._problems(heard, memory))
        kind = _kind_of(heard, memory)
        if heard.message is None:  # what was not read says nothing about further rules
            due = ["retained"]
        else:  # nor what was not taken, about those that depend on what it says
            due = [
                name
                for name, rule in RULES.items()
                if kind in rule.of
                and (rule.of is ALL or not heard.errors)
                and (not rule.action or rule.action in wanted)
            ]
        if self._edges is None and "layout" in due:
            due.remove("layout")
        for name in due:
            if name not in problems:
                self._counts[name].kept += 1
        for name, problem in problems.items():
            self._break(name, problem, heard)
        if heard.forgiven:
            self._counts["schema"].forgiven += 1
        if isinstance(heard.message, DriveOrder) and not heard.errors:
            memory.order_id = heard.message.order_id
            memory.end = [node for node in heard.message.nodes if node.released][-1]

    def _problems(self, heard: Heard, memory: _Memory) -> list[tuple[str, str]]:
        """Return the rules that a message breaks, each with what is wrong."""
        message, found = heard.message, []
        if heard.is_retained:
            found.append(("retained", f"{heard.topic}: the broker kept it"))
        elif message is None:
            found.append(("schema", "; ".join(error.message for error in heard.errors)))
        if heard.forgiven:
            found.append(("schema", "; ".join(heard.forgiven)))
        if message is None:
            return found
        for error in heard.errors:
            fault = error.fault if isinstance(error.fault, OrderFault) else OrderFault.VALIDATION
            rule = OF_TOPIC.get(heard.topic) or OF_FAULT.get(fault, "schema")
            found.append((rule, error.message))
        found += self._header_problems(heard, message, memory)
        if isinstance(message, DriveOrder):
            found += self._order_problems(message, memory)
            if heard.has_waited and message.order_id == memory.order_id:
                found.append(("horizon", f"the robot waits at the end of '{message.order_id:.80}'"))
        return found

    def _header_problems(
        self, heard: Heard, message: Header, memory: _Memory
    ) -> list[tuple[str, str]]:
        found, topic = [], heard.topic
        own = VERSIONS[self._version].rpartition(".")[0]
        if message.version.rpartition(".")[0] != own:
            found.append(("version", f"it is {message.version:.20}; the robot speaks {own}"))
        before = memory.header_ids.get(topic)
        if before is not None and message.header_id <= before[0] and heard.payload != before[1]:
            found.append(("headerId", f"{message.header_id} follows {before[0]}"))
        memory.header_ids[topic] = message.header_id, heard.payload
        time = time_of(message.timestamp)
        if time is None or time.utcoffset() != timedelta():
            found.append(("timestamp", f"{message.timestamp:.40} is not in UTC"))
        else:
            if time < memory.times.get(topic, time):
                found.append(("timestamp", f"{message.timestamp:.40} is before the one before"))
            memory.times[topic] = time
        return found

    def _order_problems(self, order: DriveOrder, memory: _Memory) -> list[tuple[str, str]]:
        found, first = [], order.nodes[0] if order.nodes else None
        parts = (*(n.node_id for n in order.nodes), *(e.edge_id for e in order.edges))
        odd = [name for name in (order.order_id, *parts) if not PLAIN.fullmatch(name)]
        if odd:
            found.append(("ids", f"'{odd[0]:.80}'"))
        if order.order_id != memory.order_id:
            if order.order_update_id != 0 or (first is not None and first.sequence_id != 0):
                found.append(("first update", f"orderUpdateId is {order.order_update_id}"))
        elif first is not None and memory.end is not None and first.key == memory.end.key:
            if first != memory.end:
                found.append(("base", f"node '{first.node_id:.80}' differs from before"))
        ends = zip(order.nodes, order.nodes[1:], strict=False)
        edges = self._edges
        for start, end in ends if edges is not None else ():
            if edges is not None and (start.node_id, end.node_id) not in edges:
                found.append(("layout", f"no edge from '{start.node_id}' to '{end.node_id}'"))
                break
        for node in order.nodes:
            place, own = node.node_position, self._places.get(node.node_id)
            if place and own and math.dist((place.x, place.y), own) > max(EXACT, place.deviation):
                text = f"node '{node.node_id:.80}' is at ({place.x:g}, {place.y:g}), not {own}"
                found.append(("layout", text))
                break
        return found

    def _break(self, name: str, problem: str, heard: Heard) -> None:
        count = self._counts[name]
        if name == "schema" and heard.forgiven:
            problem = f"forgiven: {problem}"
        else:
            count.broken += 1
        if count.first is None:
            text = heard.payload[:LONGEST].decode(errors="replace")
            count.first = {
                "robot": heard.robot, "topic": heard.topic, "problem": problem, "message": text,
            }  # fmt: skip
            self._note(f"{heard.robot}: rule '{name}' ({RULES[name].text}): {problem:.300}")

    def report(self, check: str, orders: Mapping[str, Any]) -> dict[str, Any]:
        """Return the verdict for `vda5050.json`.

        Args:
            check: `strict` or `lenient`.
            orders: What became of them, as `tally.in_numbers` returns it.
        """
        rules = [
            {
                "rule": name,
                "text": RULES[name].text,
                "is_duty": RULES[name].is_duty,
                "seen": count.kept + count.broken + count.forgiven,
                "kept": count.kept,
                "broken": count.broken,
                "forgiven": count.forgiven,
                "first": count.first,
            }
            for name, count in self._counts.items()
        ]
        return {
            "schema": 1,
            "version": self._version,
            "check": check,
            "messages": self._messages,
            "orders": orders,
            "broken": self.broken,
            "rules": rules,
        }


def _wanted(message: Header | None) -> set[str]:
    """Return the types of the instant actions in a message."""
    if not isinstance(message, InstantActions):
        return set()
    return {action.action_type for action in message.actions}


def _kind_of(heard: Heard, memory: _Memory) -> str:
    if not isinstance(heard.message, DriveOrder):
        return heard.topic
    return UPDATE if heard.message.order_id == memory.order_id else NEW


def summary(report: Mapping[str, Any]) -> str:
    """Return a report in one sentence."""
    seen = sum(bool(rule["seen"]) for rule in report["rules"])
    names = ", ".join(report["broken"])
    found = f"broke {len(report['broken'])}: {names}" if names else "broke none"
    return f"VDA 5050: {report['messages']} messages touched {seen} rules and {found}"

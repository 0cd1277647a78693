"""The actions that robots offer: where each may stand, its parameters, and how it runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from swarm_vda5050.fine import FINE
from swarm_vda5050.messages import ActionState, ActionStatus, OrderAction

HANDLING_TIME = 5.0  # [s] of a pick or drop that names no duration
LONGEST = 86_400.0  # [s] of an action
TRIGGER = "FLEET_CONTROL"  # triggerType that robots know
CURRENT_PATIENCE = 10.0  # [s] without current after which startCharging fails


class ActionScope(Enum):
    """Where an action may stand."""

    NODE = "NODE"
    EDGE = "EDGE"
    ZONE = "ZONE"
    INSTANT = "INSTANT"


@dataclass(frozen=True, slots=True)
class ActionOffer:
    """One action that robots offer."""

    scopes: tuple[ActionScope, ...]  # where it may stand
    about: str  # for people, in the factsheet
    # parameters that it needs, with their type in the factsheet
    required: dict[str, str] = field(default_factory=dict)
    optional: dict[str, str] = field(default_factory=dict)  # parameters that it may have
    drives: bool = False  # whether the robot drives for it, so that nothing else may drive


_ON_WAY = (ActionScope.NODE, ActionScope.EDGE)
_STANDING = (ActionScope.NODE, ActionScope.INSTANT)
_INSTANT = (ActionScope.INSTANT,)
_STATION = {"stationName": "STRING", "stationType": "STRING"}
_LOAD = {"loadId": "STRING", "loadType": "STRING"} | _STATION
_DURATION = {"duration": "FLOAT"}
_POSE = {"x": "FLOAT", "y": "FLOAT", "theta": "FLOAT", "mapId": "STRING"}
_NODE, _ORDER, _ZONE_SET = {"lastNodeId": "STRING"}, {"orderId": "STRING"}, {"zoneSetId": "STRING"}
_MAP = {"mapId": "STRING", "mapVersion": "STRING"}
_INIT_POSITION = ActionOffer(_STANDING, "Take a pose as one's own.", _POSE, _NODE)
_ACTION = {"actionId": "STRING"}
_WAIT = ActionOffer(_ON_WAY, "Wait for `duration` [s].", required=_DURATION)
_OF_BOTH: dict[str, ActionOffer] = {
    "pick": ActionOffer(_ON_WAY, "Take a load; lasts `duration`.", optional=_LOAD | _DURATION),
    "drop": ActionOffer(_ON_WAY, "Put the load down, likewise.", optional=_LOAD | _DURATION),
    "wait": _WAIT,
    "finePositioning": ActionOffer(
        (ActionScope.NODE,),
        f"Stand on the node's exact pose, within {FINE} m and rad.",
        optional=_STATION,
        drives=True,
    ),
    "startCharging": ActionOffer(_STANDING, "Finished when current flows."),
    "stopCharging": ActionOffer(_STANDING, "The robot may leave the charger."),
    "startPause": ActionOffer(_INSTANT, "Stop, and pause the actions."),
    "stopPause": ActionOffer(_INSTANT, "Go on after a pause."),
    "stateRequest": ActionOffer(_INSTANT, "Publish the state."),
    "factsheetRequest": ActionOffer(_INSTANT, "Publish the factsheet."),
    "cancelOrder": ActionOffer(_INSTANT, "Give up the order.", optional=_ORDER),
    "logReport": ActionOffer(_INSTANT, "Write the state down.", required={"reason": "STRING"}),
}
_OF_MAPS = {
    "downloadMap": ActionOffer(
        _INSTANT,
        "Fetch a Nav2 map of the running world: its YAML, or a zip with its image.",
        _MAP | {"mapDownloadLink": "STRING"},
        {"mapHash": "STRING"},
    ),
    "enableMap": ActionOffer(_STANDING, "Use a map that the robot has.", required=_MAP),
    "deleteMap": ActionOffer(_INSTANT, "Forget a map that is not in use.", required=_MAP),
}
_OF_20 = _OF_BOTH | {"initPosition": _INIT_POSITION}
_OF_21 = _OF_20 | _OF_MAPS
_OF_3 = (
    _OF_BOTH
    | _OF_MAPS
    | {
        "initializePosition": _INIT_POSITION,
        "wait": replace(_WAIT, scopes=(*_ON_WAY, ActionScope.ZONE)),
        "waitForTrigger": ActionOffer(
            (ActionScope.NODE, ActionScope.ZONE),
            f"Wait for the instant action `trigger`; triggerType has {TRIGGER}.",
            {"triggerType": "ARRAY"},
        ),
        "trigger": ActionOffer(_INSTANT, "Finish waitForTrigger."),
        "retry": ActionOffer(_INSTANT, "Do a RETRIABLE action again.", _ACTION),
        "skipRetry": ActionOffer(_INSTANT, "Let a RETRIABLE action fail.", _ACTION),
        "clearInstantActions": ActionOffer(_STANDING, "Forget the instant actions that ended."),
        "clearZoneActions": ActionOffer(_STANDING, "Forget the actions of zones that ended."),
        "downloadZoneSet": ActionOffer(
            _INSTANT,
            "Fetch a zone set: the JSON of a zoneSet message, or of the zoneSet in it.",
            _ZONE_SET | {"zoneSetDownloadLink": "STRING"},
            {"zoneSetHash": "STRING"},
        ),
        "enableZoneSet": ActionOffer(_STANDING, "Use a zone set.", required=_ZONE_SET),
        "deleteZoneSet": ActionOffer(_INSTANT, "Forget a zone set.", required=_ZONE_SET),
    }
)
OFFERED = {"2.0": _OF_20, "2.1": _OF_21, "3.0": _OF_3}  # by version
INTERNAL = {"initializePosition": "initPosition"}  # names of 2.1
PAUSABLE = ("pick", "drop", "wait", "finePositioning")
# which end when they are done, not by the clock
OPEN_ENDED = ("downloadMap", "downloadZoneSet", "finePositioning", "waitForTrigger")


def check_action(
    action: OrderAction, scope: ActionScope, offered: Mapping[str, ActionOffer]
) -> str:
    """Return what is wrong with an action; empty if the robot can do it.

    Args:
        offered: The actions of the version, by actionType.
    """
    offer = offered.get(action.action_type)
    if offer is None or scope not in offer.scopes:
        place = "" if offer is None else f" as an action of scope {scope.value}"
        return f"the action '{action.action_type}' is not offered{place}"
    if offer.drives and action.blocking_type.allows_driving:
        wrong = f"the blockingType {action.blocking_type}; it drives itself: SOFT or HARD"
        return f"{action.action_type} has {wrong}"
    known = offer.required | offer.optional
    keys = [parameter.key for parameter in action.action_parameters]
    for key in keys:
        if key not in known:
            return f"{action.action_type} has no parameter '{key}'; it takes {sorted(known)}"
        if keys.count(key) > 1:
            return f"{action.action_type} has the parameter '{key}' twice"
    for key in offer.required:
        if key not in keys:
            return f"{action.action_type} lacks the parameter '{key}'"
    for parameter in action.action_parameters:
        kind, value = known[parameter.key], parameter.value
        if kind == "ARRAY":
            if not isinstance(value, list) or TRIGGER not in value:
                return f"{parameter.key} is {value!r:.80}; expected an array with {TRIGGER}"
            continue
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (is_number and math.isfinite(value) if kind == "FLOAT" else isinstance(value, str)):
            expected = "a number" if kind == "FLOAT" else "a text"
            return f"{parameter.key} of {action.action_type} is {value!r:.80}; expected {expected}"
        if parameter.key == "duration" and not 0.0 <= value <= LONGEST:
            return f"duration of {action.action_type} is {value} s; expected 0 to {LONGEST:g}"
    return ""


class RunningAction:
    """One action, from its acceptance to its end.

    Attributes:
        action: Action as the fleet control sent it.
        scope: Where it stood.
        status: How far it is.
        result: For people; empty without one.
        is_triggered: Whether its node or edge is reached.
    """

    def __init__(self, action: OrderAction, scope: ActionScope) -> None:
        self.action = action
        self.scope = scope
        self.status = ActionStatus.WAITING
        self.result = ""
        self.is_triggered = False
        self._left = 0.0  # [s] that it still takes
        self._at = 0.0  # [s] when that was

    @property
    def kind(self) -> str:
        """Its actionType in 2.1."""
        return INTERNAL.get(self.action.action_type, self.action.action_type)

    @property
    def is_active(self) -> bool:
        """Whether it runs or pauses."""
        return self.status in (ActionStatus.INITIALIZING, ActionStatus.RUNNING, ActionStatus.PAUSED)

    def state(self) -> ActionState:
        """Return its state for the fleet control."""
        return ActionState(
            action_id=self.action.action_id,
            action_type=self.action.action_type,
            action_status=self.status,
            action_description=self.action.action_description or None,
            result_description=self.result or None,
        )

    def begin(self, now: float) -> None:
        """Begin to run.

        Args:
            now: Simulated time [s].
        """
        usual = HANDLING_TIME if self.kind in ("pick", "drop") else CURRENT_PATIENCE
        self._left = float(self.action.parameter("duration", usual))
        self._at = now
        self.status = ActionStatus.RUNNING

    def is_over(self, now: float) -> bool:
        """Let time pass; return whether its time is up.

        Args:
            now: Simulated time [s].
        """
        if self.status is ActionStatus.RUNNING:
            self._left -= now - self._at
        self._at = now
        return self.status is ActionStatus.RUNNING and self._left <= 0.0

    def pause(self, *, is_paused: bool) -> None:
        """Stop the clock of an action that can pause, or go on."""
        if self.kind in PAUSABLE and self.is_active:
            self.status = ActionStatus.PAUSED if is_paused else ActionStatus.RUNNING

    def finish(self, result: str = "") -> None:
        """End well."""
        self.status, self.result = ActionStatus.FINISHED, result

    def miss(self, reason: str) -> None:
        """End badly, or wait to be done again if the fleet control wants that."""
        if self.action.retriable:
            self.status, self.result = ActionStatus.RETRIABLE, reason
        else:
            self.fail(reason)

    def fail(self, reason: str) -> None:
        """End badly, unless it has ended."""
        if not self.status.is_final:
            self.status, self.result = ActionStatus.FAILED, reason

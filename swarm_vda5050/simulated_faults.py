"""Faults on demand: what a robot pretends, so that fleet controls can be tested on it.

A fault begins with an instant action named below, lasts `duration` [s], for ever without one, and
ends with `simEnd`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from swarm_vda5050.actions import ActionOffer, ActionScope
from swarm_vda5050.faults import CRITICAL, FATAL, URGENT, WARNING, ActiveError, OrderFault
from swarm_vda5050.standard import TABLES, Words

_DURATION = {"duration": "FLOAT"}
_INSTANT = (ActionScope.INSTANT,)
STOP, MODE, ACTION, LOST = (
    "simEmergencyStop",
    "simOperatingMode",
    "simFailAction",
    "simLoseLocation",
)
ERROR, BATTERY, MUTE = "simError", "simBattery", "simIgnoreOrder"
CUT, SLOW, END = "simBreakConnection", "simSlowState", "simEnd"
SIMULATED: dict[str, ActionOffer] = {
    STOP: ActionOffer(_INSTANT, "Emergency stop of a `type`.", {"type": "STRING"}, _DURATION),
    MODE: ActionOffer(_INSTANT, "Operating mode `mode`.", {"mode": "STRING"}, _DURATION),
    ACTION: ActionOffer(_INSTANT, "The next action fails.", optional={"actionType": "STRING"}),
    LOST: ActionOffer(_INSTANT, "The robot does not know where it is.", optional=_DURATION),
    ERROR: ActionOffer(
        _INSTANT,
        "An error of a type and a level.",
        {"errorType": "STRING", "errorLevel": "STRING"},
        {"errorDescription": "STRING"} | _DURATION,
    ),
    BATTERY: ActionOffer(_INSTANT, "Battery at `charge` %.", {"charge": "FLOAT"}, _DURATION),
    MUTE: ActionOffer(_INSTANT, "The next order is neither taken nor answered."),
    CUT: ActionOffer(_INSTANT, "The connection breaks, with its last will.", _DURATION),
    SLOW: ActionOffer(_INSTANT, "One state each `period` s.", {"period": "FLOAT"}, _DURATION),
    END: ActionOffer(_INSTANT, "All that is simulated ends."),
}
LEVELS = (WARNING, URGENT, CRITICAL, FATAL)
DRIVES_ON = ("AUTOMATIC", "SEMIAUTOMATIC")  # modes in which orders are driven
INTERVENED = "INTERVENED"  # in which they wait; of 3.0


class NamedFault(NamedTuple):
    """An error of any type."""

    name: str
    level: str

    def name_in(self, major: int) -> str:
        """Return the errorType of a version: the same in all."""
        return self.name

    def level_in(self, major: int) -> str:
        """Return the errorLevel of a version; 2.x has WARNING and FATAL only."""
        if major > 2:
            return self.level
        return FATAL if self.level in (CRITICAL, FATAL) else WARNING


@dataclass(slots=True)
class SimulatedFaults:
    """Faults of one robot that are active."""

    version: str  # like `2.1`
    _active: dict[str, tuple[Mapping[str, Any], float]] = field(default_factory=dict)  # and end [s]

    def begin(self, kind: str, parameters: Mapping[str, Any], now: float) -> str:
        """Begin a fault, in place of one of its kind; return what is wrong, if anything.

        Args:
            kind: A key of `SIMULATED`.
            now: Simulated time [s].
        """
        if kind == END:
            self._active.clear()
            return ""
        for key, table in (("mode", "state"), ("type", "safety")):
            words = _words(self.version, table, "operatingMode" if key == "mode" else "eStop")
            if key in parameters and parameters[key] not in words:
                return f"{key} is '{parameters[key]:.40}'; expected {', '.join(words)}"
        if parameters.get("errorLevel", FATAL) not in LEVELS:
            return f"errorLevel is '{parameters['errorLevel']:.40}'; expected {', '.join(LEVELS)}"
        if not 0.0 <= parameters.get("charge", 0.0) <= 100.0 or parameters.get("period", 1.0) <= 0:
            return "charge is from 0 to 100 %, period positive"
        self._active[kind] = parameters, now + parameters.get("duration", math.inf)
        return ""

    def pass_time(self, now: float) -> None:
        """End what is over.

        Args:
            now: Simulated time [s].
        """
        self._active = {kind: each for kind, each in self._active.items() if now < each[1]}

    def _read(self, kind: str, key: str, default: Any) -> Any:
        return self._active[kind][0].get(key, default) if kind in self._active else default

    @property
    def emergency_stop(self) -> str:
        """Type of the emergency stop; `NONE` without one."""
        return str(self._read(STOP, "type", "NONE"))

    @property
    def mode(self) -> str:
        """Operating mode; empty for the robot's own."""
        return str(self._read(MODE, "mode", ""))

    @property
    def is_intervened(self) -> bool:
        """Whether somebody intervenes: the order is kept, but the fleet control not in charge."""
        return self.mode == INTERVENED

    @property
    def has_no_place(self) -> bool:
        """Whether the robot is to name no node as its last, as 3.0 has it in some modes."""
        return self.version == "3.0" and self.mode in ("STARTUP", "SERVICE", "TEACHIN")

    @property
    def is_lost(self) -> bool:
        """Whether the robot does not know where it is."""
        return LOST in self._active

    @property
    def charge(self) -> float | None:
        """Charge [%]; None for the robot's own."""
        found: float | None = self._read(BATTERY, "charge", None)
        return found

    @property
    def state_period(self) -> float:
        """Time [s] between two states at least; 0 for any."""
        return float(self._read(SLOW, "period", 0.0))

    @property
    def is_cut(self) -> bool:
        """Whether the connection is broken."""
        return CUT in self._active

    @property
    def holds(self) -> bool:
        """Whether the robot must not drive."""
        is_fatal = any(error.fault.level_in(3) == FATAL for error in self.errors)
        return self.emergency_stop != "NONE" or self.is_lost or is_fatal or self.is_intervened

    @property
    def errors(self) -> list[ActiveError]:
        """Errors that the faults report."""
        found = []
        if ERROR in self._active:
            read = self._active[ERROR][0]
            fault = NamedFault(read["errorType"], read["errorLevel"])
            found.append(ActiveError(fault, read.get("errorDescription", "simulated"), {}))
        if self.is_lost:
            text = "the robot does not know where it is (simulated)"
            found.append(ActiveError(OrderFault.LOCALIZATION, text, {}))
        return found

    def takes_order(self) -> bool:
        """Whether an order is to be heard; one that is not ends the fault."""
        return self._active.pop(MUTE, None) is None

    def fails(self, kind: str) -> bool:
        """Whether an action of a type is to fail as it begins; one that does ends the fault."""
        if ACTION not in self._active or self._read(ACTION, "actionType", kind) != kind:
            return False
        del self._active[ACTION]
        return True


def _words(version: str, table: str, inside: str) -> list[str]:
    fields = TABLES[version][table].values()
    kinds = [each.kind for each in fields if each.inside == inside]
    return [word for kind in kinds if isinstance(kind, Words) for word in kind.inside.values()]

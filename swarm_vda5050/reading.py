"""Messages against the tables of the standard: what is wrong, or what was forgiven; and writing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from swarm_common.model.errors import SwarmError
from swarm_common.model.records import wrap_angle
from swarm_vda5050.standard import (
    ANGLE,
    NEEDS,
    TABLES,
    VERSIONS,
    Anything,
    Each,
    Flag,
    Kind,
    Number,
    Record,
    Text,
    WireField,
    Words,
    versions_of,
)

SHOWN = 60  # characters of a value in a message
TYPES = {Text: "a text", Flag: "true or false", Number: "a number", Words: "a text"}


class FieldError(SwarmError):
    """A message is not what the standard says."""


class Reader:
    """Reads one message of a version.

    Attributes:
        forgiven: What was wrong and taken all the same.
    """

    def __init__(self, version: str, *, is_lenient: bool) -> None:
        """Begin without remarks.

        Args:
            is_lenient: Whether to take what can be understood although it is wrong.
        """
        self._version = version
        self._is_lenient = is_lenient
        self.forgiven: list[str] = []

    def record(self, content: Any, table: str, path: str = "") -> dict[str, Any]:
        """Return an object with the names that its fields have inside the package.

        Args:
            table: Its table in the standard.
            path: Where it stands in the message; empty for the message itself.

        Raises:
            FieldError: For the first thing that is wrong, or that cannot be forgiven.
        """
        if not isinstance(content, Mapping):
            raise FieldError(f"{path or 'the message'} is {_shown(content)}; expected an object")
        fields, read = TABLES[self._version][table], {}
        for wire, value in content.items():
            where = f"{path}.{wire}" if path else str(wire)
            field = fields.get(wire) or self._unknown(table, wire, where)
            if field is not None and field.inside not in read:
                read[field.inside] = self._value(value, field.kind, where)
        missing = [
            wire for wire, each in fields.items() if each.is_required and each.inside not in read
        ]
        missing += [n for n in NEEDS.get(str(read.get("zoneType")), ()) if n not in read]
        if missing:
            self._forgive(f"{path or 'the message'} lacks `{missing[0]}`")
        return read

    def _unknown(self, table: str, wire: str, where: str) -> WireField | None:
        """Forgive a field that the version has not; return what it is in another one, if any."""
        others = versions_of(table, wire)
        if not others:
            self._forgive(f"{where:.200} is no field of the standard")
            return None
        self._forgive(f"{where} is a field of {' and '.join(others)}, not of {self._version}")
        return TABLES[others[-1]][table][wire]

    def _forgive(self, problem: str) -> None:
        if not self._is_lenient:
            raise FieldError(problem)
        self.forgiven.append(problem)

    def _value(self, value: Any, kind: Kind, where: str) -> Any:
        match kind:
            case Record(table):
                return self.record(value, table, where)
            case Each(inner, least):
                if not isinstance(value, list | tuple):
                    raise FieldError(f"{where} is {_shown(value)}; expected an array")
                if len(value) < least:
                    raise FieldError(f"{where} has {len(value)} entries; expected {least} or more")
                return [self._value(each, inner, f"{where}[{i}]") for i, each in enumerate(value)]
            case Anything():
                if value is None:
                    raise FieldError(f"{where} is null")
                return value
            case Words(inside):
                return self._word(self._typed(value, kind, where), inside, where)
            case Number():
                return self._number(self._typed(value, kind, where), kind, where)
            case Text():
                return self._text(self._typed(value, kind, where), kind, where)
        return self._typed(value, kind, where)

    def _typed(self, value: Any, kind: Kind, where: str) -> Any:
        """Return a value of the JSON type of a kind, converted if that is forgiven."""
        expected = TYPES[type(kind)]
        found = {bool: "true or false", str: "a text", int: "a number", float: "a number"}
        if found.get(type(value)) == expected:
            return value
        problem = f"{where} is {_shown(value)}; expected {expected}"
        converted = _converted(value, kind)
        if converted is None:
            raise FieldError(problem)
        self._forgive(problem)
        return converted

    def _word(self, value: str, inside: Mapping[str, str], where: str) -> str:
        if value in inside:
            return inside[value]
        problem = f"{where} is {_shown(value)}; expected {', '.join(inside)}"
        known = {_bare(wire): word for wire, word in inside.items()}
        if _bare(value) not in known:
            raise FieldError(problem)
        self._forgive(problem)
        return known[_bare(value)]

    def _number(self, value: float, kind: Number, where: str) -> float:
        if not math.isfinite(value):
            raise FieldError(f"{where} is {value}; expected a number")
        if kind.is_whole and value != int(value):
            raise FieldError(f"{where} is {value}; expected a whole number")
        if not kind.low <= value <= kind.high:
            bounds = f"{kind.low:g} to {kind.high:g}".replace("4.29497e+09", "2^32 - 1")
            self._forgive(f"{where} is {value:g}; expected {bounds}")
            value = wrap_angle(value) if kind == ANGLE else value
        return int(value) if kind.is_whole else float(value)

    def _text(self, value: str, kind: Text, where: str) -> str:
        if not kind.least <= len(value) <= kind.most:
            bounds = f"{kind.least} to {kind.most}"
            raise FieldError(f"{where} has {len(value)} characters; expected {bounds}")
        if kind.is_time and time_of(value) is None:
            self._forgive(f"{where} is {_shown(value)}; expected a time like 2026-01-31T12:00:00Z")
        return value


def time_of(text: str) -> datetime | None:
    """Return the time that a timestamp in ISO 8601 says; None if it is none."""
    try:
        return datetime.fromisoformat(text) if len(text) > len("2026-01-31") else None
    except ValueError:
        return None


def written(content: Mapping[str, Any], table: str, version: str) -> dict[str, Any]:
    """Return an object as a version has it on the wire: its fields, under its names.

    Args:
        content: Names inside the package; what the version has not is left out.
        table: Its table in the standard.
    """
    result: dict[str, Any] = {}
    for wire, field in TABLES[version][table].items():
        value = content.get(field.inside)
        if value is not None and wire == _FIRST[version][table][field.inside]:
            result[wire] = _wire_value(value, field.kind, version)
    return result


def _wire_value(value: Any, kind: Kind, version: str) -> Any:
    match kind:
        case Record(table) if isinstance(value, Mapping):
            return written(value, table, version)
        case Each(inner):
            return [_wire_value(each, inner, version) for each in value]
        case Words(inside):
            return next((wire for wire, word in inside.items() if word == value), value)
    return value


_FIRST = {
    version: {
        table: {field.inside: wire for wire, field in reversed(fields.items())}
        for table, fields in TABLES[version].items()
    }
    for version in VERSIONS
}


def _converted(value: Any, kind: Kind) -> Any:
    """Return a value of another JSON type as one of a kind; None if it cannot be one."""
    if isinstance(kind, Text) and isinstance(value, int | float) and not isinstance(value, bool):
        return str(value)
    if isinstance(kind, Number) and isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return None
    if isinstance(kind, Flag):
        return {"true": True, "false": False}.get(str(value).lower())
    return None


def _bare(word: str) -> str:
    return word.upper().replace("_", "")


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"

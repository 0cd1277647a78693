"""The keys `orders`, `groups`, `dispatch` and `capacity` of a mission file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarm_common.files.yaml_io import check_keys, name_in, number
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_mission.orders.arrivals import Arrivals, Shift
from swarm_mission.orders.order import OrderPlan, OrderStream, expand
from swarm_mission.orders.service import AT_ONCE, parse_service

KEYS = ("orders", "groups", "dispatch", "capacity")
DISPATCHES = ("claim", "nearest", "fifo", "central")
NAMES = ("orders.*.from", "orders.*.from.*", "orders.*.to", "orders.*.to.*", "orders.*.times")
NAMES_OF_GROUPS = ("groups.*.*", "dispatch")
STREAM_KEYS = (
    "from", "to", "rate", "every", "shifts", "times", "batch", "service", "priority", "due",
)  # fmt: skip
SHIFT_KEYS = ("begin", "end", "rate", "every")
LONGEST_FILE = 10_000_000  # [bytes] of times
PRIORITIES = 1000  # largest size of one


def parse_orders(content: Mapping[str, Any], path: Path) -> OrderPlan:
    """Return the orders of a mission file.

    Args:
        path: Path of the file; files of times lie beside it.

    Raises:
        ConfigError: If something in it is wrong.
    """
    groups = _parse_groups(content.get("groups", {}), f"{path}: groups")
    streams = content["orders"]
    if not isinstance(streams, list):
        raise ConfigError(f"{path}: orders is {streams!r}; expected a list of streams")
    try:
        return OrderPlan(
            streams=tuple(
                _parse_stream(stream, index, groups, path)
                for index, stream in enumerate(streams, 1)
            ),
            dispatch=_parse_dispatch(content.get("dispatch", "claim"), f"{path}: dispatch"),
            capacity=_integer(content.get("capacity", 1), "capacity"),
        )
    except UnknownNameError:
        raise
    except ConfigError as error:
        text = str(error)
        raise ConfigError(text if text.startswith(str(path)) else f"{path}: {text}") from None


def times_files(content: Mapping[str, Any]) -> list[str]:
    """Return the names of the files of times that a mission file refers to, each once."""
    streams = content.get("orders")
    found = [each.get("times") for each in streams or () if isinstance(each, dict)]
    return list(dict.fromkeys(name for name in found if isinstance(name, str)))


def _parse_groups(content: object, where: str) -> dict[str, tuple[str, ...]]:
    if not isinstance(content, dict):
        raise ConfigError(f"{where} is {content!r}; expected lines like 'loaders: [a, b]'")
    groups = {}
    for name, members in content.items():
        if not isinstance(members, list) or not members:
            raise ConfigError(f"{where}.{name} is {members!r}; expected a list of stations")
        groups[name] = tuple(name_in(member, f"{where}.{name}") for member in members)
    for name in groups:
        try:
            expand((name,), groups)
        except ConfigError as error:
            raise ConfigError(f"{where.removesuffix('groups')}{error}") from None
    return groups


def _parse_dispatch(value: object, where: str) -> str:
    text = name_in(value, where)
    if text not in DISPATCHES and ":" not in text:
        raise UnknownNameError("dispatch", text, (*DISPATCHES, "module:Class"), where)
    return text


def _parse_stream(
    content: object, index: int, groups: Mapping[str, tuple[str, ...]], path: Path
) -> OrderStream:
    where = f"{path}: orders, stream {index}"
    if not isinstance(content, dict):
        raise ConfigError(f"{where} is {content!r}; expected {{from: ..., to: ..., rate: ...}}")
    check_keys(content, STREAM_KEYS, where)
    try:
        loading = unloading = AT_ONCE
        if "service" in content:
            loading, unloading = parse_service(content["service"], f"{where}: service")
        priority = _integer(content.get("priority", 0), "priority")
        if abs(priority) > PRIORITIES:
            raise ConfigError(f"priority is {priority}; expected -{PRIORITIES} to {PRIORITIES}")
        return OrderStream(
            number=index,
            origins=_parse_ends(content, "from", groups),
            targets=_parse_ends(content, "to", groups),
            arrivals=_parse_arrivals(content, path),
            loading=loading,
            unloading=unloading,
            priority=priority,
            due=number(content["due"], "due") if "due" in content else None,
        )
    except UnknownNameError:
        raise
    except ConfigError as error:
        text = str(error)
        raise ConfigError(text if text.startswith(where) else f"{where}: {text}") from None


def _parse_ends(
    content: Mapping[str, Any], key: str, groups: Mapping[str, tuple[str, ...]]
) -> tuple[str, ...]:
    value = content.get(key)
    names = value if isinstance(value, list) else [value]
    if value is None or not names:
        raise ConfigError(f"'{key}' is missing; expected a station, a group, or a list of them")
    return expand(tuple(name_in(name, key) for name in names), groups)


def _parse_arrivals(content: Mapping[str, Any], path: Path) -> Arrivals:
    given = [key for key in ("rate", "every", "shifts", "times") if key in content]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        raise ConfigError(f"expected one of 'rate', 'every', 'shifts' and 'times'; found {found}")
    batch = _integer(content.get("batch", 1), "batch")
    if "times" in content:
        name = name_in(content["times"], "times")
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise ConfigError(f"times is '{name}'; expected a file in the folder of the mission")
        return Arrivals(listed=_read_times(path.parent / name), batch=batch)
    if "shifts" in content:
        shifts = content["shifts"]
        if not isinstance(shifts, list) or not shifts:
            raise ConfigError(f"shifts is {shifts!r}; expected a list of shifts")
        parsed = [_parse_shift(shift, f"shifts, {i}") for i, shift in enumerate(shifts, 1)]
        return Arrivals(shifts=tuple(parsed), batch=batch)
    shift = Shift(**{key: number(content[key], key) for key in given})
    return Arrivals(shifts=(shift,), batch=batch)


def _parse_shift(content: object, where: str) -> Shift:
    if not isinstance(content, dict):
        raise ConfigError(f"{where} is {content!r}; expected {{begin: s, end: s, rate: per hour}}")
    check_keys(content, SHIFT_KEYS, where)
    return Shift(**{key: number(content[key], f"{where}: {key}") for key in content})


def _read_times(path: Path) -> tuple[float, ...]:
    """Return the times [s] in the first column of a CSV file, which may have a heading."""
    try:
        content = path.read_bytes()
        lines = content.decode().splitlines() if len(content) <= LONGEST_FILE else []
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"cannot read times from {path}: {error}") from error
    times: list[float] = []
    for count, line in enumerate(lines, 1):
        text = line.split(",")[0].strip()
        if not text or (count == 1 and text.casefold() in ("t", "time", "times")):
            continue
        try:
            times.append(number(float(text), "time"))
        except (ValueError, ConfigError):
            raise ConfigError(
                f"{path}, line {count}: '{text[:50]}' is no time; expected seconds"
            ) from None
    if not times:
        raise ConfigError(f"{path} has no times, or more than {LONGEST_FILE // 1_000_000} MB")
    return tuple(times)


def _integer(value: object, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ConfigError(f"{what} is {value!r}; expected an integer")
    return value

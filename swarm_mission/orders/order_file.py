"""The keys `orders`, `groups`, `dispatch` and `capacity` of a mission file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta

from swarm_common.files.convert import convert, located
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.schema import Name, Positive, Schema
from swarm_mission.orders.arrivals import Amount, Arrivals, Shift
from swarm_mission.orders.order import OrderPlan, OrderStream, expand
from swarm_mission.orders.service import Seconds, ServiceEnds, service_times

ORDER_KEYS = ("groups", "dispatch", "capacity")
DISPATCHES = ("claim", "nearest", "fifo", "central")
LONGEST_FILE = 10_000_000  # [bytes] of times
PRIORITIES = 1000  # largest size of one
Names = Annotated[tuple[Name, ...], Meta(min_length=1)]


class StreamEntry(Schema, rename={"origins": "from", "targets": "to"}):
    """An entry of `orders`."""

    origins: Name | Names  # stations, and groups of them
    targets: Name | Names
    rate: float | None = None
    every: float | None = None
    shifts: Annotated[tuple[Shift, ...], Meta(min_length=1)] | None = None
    times: Name | None = None
    batch: Amount = 1
    service: Seconds | ServiceEnds = 0.0
    priority: Annotated[int, Meta(ge=-PRIORITIES, le=PRIORITIES)] = 0
    due: Positive | None = None

    def stream(self, number: int, groups: Mapping[str, tuple[str, ...]], path: Path) -> OrderStream:
        """Return the stream.

        Args:
            number: Number of the stream, from 1.
            groups: Groups of the mission file.
            path: Mission file, in whose folder files of times are.
        """
        origins, targets = (
            expand((names,) if isinstance(names, str) else names, groups)
            for names in (self.origins, self.targets)
        )
        loading, unloading = service_times(self.service)
        return OrderStream(
            number=number,
            origins=origins,
            targets=targets,
            arrivals=self._arrivals(path),
            loading=loading,
            unloading=unloading,
            priority=self.priority,
            due=self.due,
        )

    def _arrivals(self, path: Path) -> Arrivals:
        ways = {"rate": self.rate, "every": self.every, "shifts": self.shifts, "times": self.times}
        given = [key for key, value in ways.items() if value is not None]
        if len(given) != 1:
            raise ConfigError(
                "expected one of 'rate', 'every', 'shifts' and 'times'; found "
                + (" and ".join(given) or "none")
            )
        if self.times is not None:
            if Path(self.times).is_absolute() or ".." in Path(self.times).parts:
                raise ConfigError(
                    f"times is '{self.times}'; expected a file in the folder of the mission"
                )
            return Arrivals(listed=_read_times(path.parent / self.times), batch=self.batch)
        shifts = self.shifts or (Shift(rate=self.rate or 0.0, every=self.every or 0.0),)
        return Arrivals(shifts=shifts, batch=self.batch)


class OrderFile(Schema):
    """Orders of a mission file."""

    orders: tuple[StreamEntry, ...] | None = None
    groups: dict[str, Names] | None = None
    dispatch: Name | None = None
    capacity: Amount | None = None

    def __post_init__(self) -> None:
        if self.dispatch not in (None, *DISPATCHES) and ":" not in str(self.dispatch):
            raise UnknownNameError("dispatch", str(self.dispatch), (*DISPATCHES, "module:Class"))
        expand(tuple(self.groups or ()), self.groups or {})

    def order_plan(self, path: Path) -> OrderPlan | None:
        """Return the orders; None if there are none.

        Args:
            path: Mission file; files of times lie beside it.

        Raises:
            ConfigError: If something in them is wrong.
        """
        if self.orders is None:
            return None
        streams = []
        for index, entry in enumerate(self.orders):
            with located(f"{path}: orders[{index}]"):
                streams.append(entry.stream(index + 1, self.groups or {}, path))
        return OrderPlan(
            streams=tuple(streams), dispatch=self.dispatch or "claim", capacity=self.capacity or 1
        )


def times_files(content: Mapping[str, Any]) -> list[str]:
    """Return the names of the files of times that a mission file refers to, each once."""
    streams = content.get("orders")
    found = [each.get("times") for each in streams or () if isinstance(each, dict)]
    return list(dict.fromkeys(name for name in found if isinstance(name, str)))


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
            times.append(convert(text, float, strict=False))
        except ConfigError:
            raise ConfigError(
                f"{path}, line {count}: '{text[:50]}' is no time; expected seconds"
            ) from None
    if not times:
        raise ConfigError(f"{path} has no times, or more than {LONGEST_FILE // 1_000_000} MB")
    return tuple(times)

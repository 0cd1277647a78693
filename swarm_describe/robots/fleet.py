"""Fleets of several robot models (`--fleet`): the model and limits of each robot."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import UNSET, Meta

from swarm_common.files.convert import read
from swarm_common.files.resources import names_to_propose, share_directory
from swarm_common.files.sites_io import parse_spawn
from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError
from swarm_common.model.records import RobotSpec
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.schema import Name, Positive, Schema, told
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.source import robot_names
from swarm_describe.robots.spec import parse_battery

LIMITS = ("max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta")  # of a robot model
SIDEWAYS = ("max_vel_y", "acc_lim_y")  # of an omnidirectional one
Names = str | tuple[str, ...] | None  # a pattern like agv{}, or a list


def limits_of(spec: RobotSpec) -> dict[str, float]:
    """Return the limits of a robot model by name, which are the defaults of its controller's.

    Returns:
        [m/s], [rad/s], [m/s²] and [rad/s²] by the names of `LIMITS`; with those of `SIDEWAYS` for
        an omnidirectional drive.
    """
    return {name: getattr(spec, name) for name in LIMITS + (SIDEWAYS if spec.is_omni else ())}


class FleetGroup(Schema):
    """Robots of one model."""

    model: Name  # or its path, which may be relative to the fleet file
    count: Annotated[int, Meta(ge=1, le=1000)]
    limits: dict[str, Positive] | None = None  # below those of the model
    battery: Any = UNSET  # what it has not is that of the model
    start: str | Mapping[str, Any] | None = None
    mission: str | None = None
    names: Names = None


class FleetFile(Schema):
    """Content of the file."""

    groups: Annotated[tuple[FleetGroup, ...], told("a list of model and count", min_length=1)]
    order: Literal["grouped", "mixed"] = "grouped"
    names: Names = None
    external: Annotated[
        tuple[str, ...] | None, told("a list of robots' names")  # that nodes of their users drive
    ] = None


@dataclass(frozen=True, slots=True)
class Member:
    """One robot of a fleet."""

    model: str  # name or path of its model
    spec: RobotSpec  # with the battery of its group
    # speeds and accelerations below those of the model, by name
    limits: Mapping[str, float] = field(default_factory=dict)
    mission: str | None = None  # name or path of its own mission; None for that of the run
    # name of a spawn of the world, or an area or circle as in sites.yaml; None for the run's
    start: str | Mapping[str, Any] | None = None
    name: str = ""  # that its group gives it; empty: by the names of the fleet

    @property
    def limits_in_force(self) -> dict[str, float]:
        """Return every limit by name: the member's own, else that of its model."""
        return limits_of(self.spec) | dict(self.limits)


@dataclass(frozen=True, slots=True)
class Fleet:
    """All robots of a run in order of their numbers."""

    members: tuple[Member, ...]
    names: RobotNames = field(default_factory=RobotNames)
    external: tuple[str, ...] = ()  # robots that nodes of their users drive

    @property
    def label(self) -> str:
        """The model, or how many there are of which."""
        counts = Counter(member.spec.model for member in self.members)
        if len(counts) == 1:
            return next(iter(counts))
        return ", ".join(f"{count} {model}" for model, count in counts.items())


def uniform_fleet(model: str, count: int) -> Fleet:
    """Return a fleet of one model."""
    if Path(model).exists() and model not in robot_names():
        model = str(Path(model).absolute())
    return Fleet((Member(model, load_robot(model)),) * count)


def load_fleet(name_or_path: str | Path) -> Fleet:
    """Return a fleet of `params/fleets` by name, or one from the user's own file.

    Args:
        name_or_path: A path has folders in it, or ends in `.yaml` or `.yml`; else it is a name.
    """
    path = _fleet_path(name_or_path)
    file = read(path, FleetFile)
    groups = [_members(group, f"{path}: groups[{i}]", path) for i, group in enumerate(file.groups)]
    rows = zip_longest(*groups) if file.order == "mixed" else groups
    members = tuple(member for row in rows for member in row if member is not None)
    names = _names_of_fleet(file.names, members, f"{path}: names")
    return Fleet(members, names, file.external or ())


def fleet_names() -> list[str]:
    """Return the names of the fleets that come with us, sorted."""
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def _fleet_path(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") or len(path.parts) > 1:
        return path
    names = fleet_names()
    if path.name not in names:
        raise UnknownNameError("fleet", path.name, names_to_propose(path.name, names))
    return _folder() / f"{path.name}.yaml"


def _folder() -> Path:
    return share_directory("params") / "params" / "fleets"


def _names_of_fleet(given: Names, members: Sequence[Member], where: str) -> RobotNames:
    """Return the names of all robots: those of the fleet, or of its groups, or the usual ones."""
    has_named_groups = any(member.name for member in members)
    if given is not None and has_named_groups:
        raise ConfigError(f"{where}: groups of the fleet have names, too; give them in one place")
    if has_named_groups:
        usual = RobotNames()
        given = tuple(m.name or usual.name_of(number) for number, m in enumerate(members, 1))
    return RobotNames() if given is None else _names(given, len(members), where)


def _names(given: str | tuple[str, ...], count: int, where: str) -> RobotNames:
    return RobotNames.of([given] if isinstance(given, str) else given, count, where)


def _members(group: FleetGroup, where: str, path: Path) -> list[Member]:
    model, spec = _model(group.model, where, path)
    _check_limits(group.limits or {}, spec, f"{where}: limits")
    if group.battery is not UNSET:
        battery = parse_battery(group.battery, f"{where}: battery", spec.battery)
        spec = replace(spec, battery=battery)
    if group.start is not None and not isinstance(group.start, str):
        parse_spawn(group.start, f"{where}: start")
    member = Member(model, spec, group.limits or {}, group.mission, group.start)
    if group.names is None:
        return [member] * group.count
    names = _names(group.names, group.count, f"{where}: names")
    return [replace(member, name=name) for name in names.first(group.count)]


def _model(name: str, where: str, path: Path) -> tuple[str, RobotSpec]:
    """Return name or path of a model, which may be relative to the fleet file, and the model."""
    beside = path.parent / name
    is_path = beside.exists() and name not in robot_names()
    model = str(beside.absolute()) if is_path else name
    try:
        return model, load_robot(model)
    except UnknownNameError as error:
        raise UnknownNameError("robot", name, error.known, where) from None
    except SwarmError as error:
        raise ConfigError(f"{where}: {error}") from error


def _check_limits(limits: Mapping[str, float], spec: RobotSpec, where: str) -> None:
    known = limits_of(spec)
    for name, limit in limits.items():
        if name not in known:
            raise UnknownNameError("key", name, known, where)
        if limit > known[name]:
            raise ConfigError(
                f"{where}.{name} is {limit}; a {spec.model} allows more than 0 to {known[name]}"
            )

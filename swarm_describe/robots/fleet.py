"""Fleets of several robot models (`--fleet`): the model and limits of each robot."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

from swarm_common.files.resources import names_to_propose, share_directory
from swarm_common.files.sites_io import parse_spawn
from swarm_common.files.yaml_io import check_keys, number, read_yaml
from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError
from swarm_common.model.records import RobotSpec
from swarm_common.model.robot_names import RobotNames
from swarm_describe.robots.battery_io import parse_battery
from swarm_describe.robots.loading import load_robot
from swarm_describe.robots.source import robot_names

LIMITS = ("max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta")  # of a robot model
SIDEWAYS = ("max_vel_y", "acc_lim_y")  # of an omnidirectional one
ORDERS = ("grouped", "mixed")
NAMES = (  # texts as written
    "order", "names", "names.*", "groups.*.model", "groups.*.mission", "groups.*.start",
    "groups.*.names", "groups.*.names.*", "external.*",
)  # fmt: skip
MOST = 1000  # robots in a group


def limits_of(spec: RobotSpec) -> dict[str, float]:
    """Return the limits of a robot model by name, which are the defaults of its controller's.

    Returns:
        [m/s], [rad/s], [m/s²] and [rad/s²] by the names of `LIMITS`; with those of `SIDEWAYS` for
        an omnidirectional drive.
    """
    return {name: getattr(spec, name) for name in LIMITS + (SIDEWAYS if spec.is_omni else ())}


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
    data = read_yaml(path, as_written=NAMES)
    check_keys(data, ("order", "groups", "names", "external"), str(path))
    order = data.get("order", "grouped")
    if order not in ORDERS:
        raise UnknownNameError("order", str(order), ORDERS, str(path))
    groups = data.get("groups")
    if not isinstance(groups, list) or not groups:
        raise ConfigError(f"{path}: groups is {groups!r}; expected a list of model and count")
    crews = [_group(item, f"{path}: groups[{i}]", path) for i, item in enumerate(groups)]
    members = _dealt(crews) if order == "mixed" else tuple(m for crew in crews for m in crew)
    names = _names_of_fleet(data.get("names"), members, f"{path}: names")
    external = data.get("external") or []
    if not isinstance(external, list) or not all(isinstance(name, str) for name in external):
        raise ConfigError(f"{path}: external is {external!r}; expected a list of robots' names")
    return Fleet(members, names, tuple(external))


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


def _dealt(crews: Sequence[Sequence[Member]]) -> tuple[Member, ...]:
    """Return one of each group in turn, as long as they last."""
    return tuple(member for row in zip_longest(*crews) for member in row if member is not None)


def _names_of_fleet(value: object, members: Sequence[Member], where: str) -> RobotNames:
    """Return the names of all robots: those of the fleet, or of its groups, or the usual ones."""
    has_named_groups = any(member.name for member in members)
    if value is not None and has_named_groups:
        raise ConfigError(f"{where}: groups of the fleet have names, too; give them in one place")
    if has_named_groups:
        usual = RobotNames()
        value = [m.name or usual.name_of(number) for number, m in enumerate(members, 1)]
    return RobotNames() if value is None else _names(value, len(members), where)


def _names(value: object, count: int, where: str) -> RobotNames:
    words = [value] if isinstance(value, str) else value
    if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise ConfigError(
            f"{where} is {value!r}; expected a pattern like agv{{}}, or a list of names"
        )
    return RobotNames.of(words, count, where)


def _group(item: object, where: str, path: Path) -> list[Member]:
    if not isinstance(item, dict):
        raise ConfigError(f"{where} is {item!r}; expected model and count")
    data: dict[str, Any] = item
    check_keys(data, ("model", "count", "limits", "battery", "start", "mission", "names"), where)
    for name in ("model", "count"):
        if name not in data:
            raise ConfigError(f"{where} lacks {name}")
    count = data["count"]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MOST:
        raise ConfigError(f"{where}: count is {count!r}; expected 1 to {MOST}")
    mission = data.get("mission")
    if mission is not None and not isinstance(mission, str):
        raise ConfigError(f"{where}: mission is {mission!r}; expected a name or a file")
    model = _model(data["model"], where, path)
    spec = load_robot(model)
    limits = _limits(data.get("limits") or {}, spec, f"{where}: limits")
    if "battery" in data:
        battery = parse_battery(data["battery"], f"{where}: battery", spec.battery)
        spec = replace(spec, battery=battery)
    start = data.get("start")
    if start is not None and not isinstance(start, str):
        parse_spawn(start, f"{where}: start")
    member = Member(model, spec, limits, mission, start)
    if data.get("names") is None:
        return [member] * count
    names = _names(data["names"], count, f"{where}: names")
    return [replace(member, name=name) for name in names.first(count)]


def _model(value: object, where: str, path: Path) -> str:
    """Return a model's name, or its path, which may be relative to the fleet file."""
    if not isinstance(value, str) or not value:
        raise ConfigError(f"{where}: model is {value!r}; expected a name or a path")
    beside = path.parent / value
    is_path = beside.exists() and value not in robot_names()
    model = str(beside.absolute()) if is_path else value
    try:
        load_robot(model)
    except UnknownNameError as error:
        raise UnknownNameError("robot", value, error.known, where) from None
    except SwarmError as error:
        raise ConfigError(f"{where}: {error}") from error
    return model


def _limits(value: object, spec: RobotSpec, where: str) -> dict[str, float]:
    if not isinstance(value, dict):
        raise ConfigError(f"{where} is {value!r}; expected {', '.join(LIMITS)}")
    data: dict[str, Any] = value
    check_keys(data, limits_of(spec), where)
    limits = {name: number(given, f"{where}.{name}") for name, given in data.items()}
    for name, limit in limits.items():
        most = getattr(spec, name)
        if not 0.0 < limit <= most:
            raise ConfigError(
                f"{where}.{name} is {limit}; a {spec.model} allows more than 0 to {most}"
            )
    return limits

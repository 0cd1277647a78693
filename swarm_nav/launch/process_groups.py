"""Packs of robots that share a process, and the participants to which each announces itself."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarm_common.files.map_io import load_map
from swarm_common.middleware import ros_env
from swarm_common.middleware.dds_profile import HELPERS
from swarm_common.model.errors import ConfigError
from swarm_nav.launch.shared_precomputation import prepare
from swarm_nav.ros.settings import NodeSettings, read_node_settings
from swarm_nav.traffic.conditions import Conditions

PROFILES = "fastdds"  # folder of the processes' profiles, beside the configuration


@dataclass(frozen=True, slots=True)
class Group:
    """The robots of one process."""

    robots: tuple[NodeSettings, ...]  # what each is started with
    profile: Path | None = None  # for its DDS participant; None to leave that to the environment

    @property
    def names(self) -> set[str]:
        """Names of the robots."""
        return {settings.name for settings in self.robots}

    def enter(self) -> None:
        """Put the profile into effect, in the process and before its participant is created."""
        if self.profile is not None:
            os.environ[ros_env.PROFILES] = str(self.profile)


class Grouping:
    """Reads `{"robots": [...], "pack", "map", "log_dir"}` of swarm-up.

    A robot is `{"name", "params", "peers", "goals"}`.

    `peers` are the ports that a robot's process announces itself to, see `participants`; without
    them it is that of the world in a small swarm. `world` is the address of the world's host, if
    that is another and `peers` are there. `goals` are (x, y) [m] in map where a robot's mission
    leads; without one it may be sent to every station.

    Attributes:
        groups: Packs to start.
        log_dir: Folder of the processes' output.
    """

    def __init__(self, path: str | Path) -> None:
        """Read the file and all parameter files.

        Args:
            path: The JSON file; profiles are written to the folder `PROFILES` beside it.

        Raises:
            SwarmError: If the configuration or a robot's parameters are unusable.
        """
        self._folder = Path(path).resolve().parent / PROFILES
        try:
            data = json.loads(Path(path).read_text(encoding="utf-8"))
            robots = [(robot["name"], robot["params"]) for robot in data["robots"]]
            peers = {robot["name"]: _ports(robot) for robot in data["robots"]}
            self._goals = {
                robot["name"]: [(float(x), float(y)) for x, y in robot.get("goals", ())]
                for robot in data["robots"]
            }
            pack = int(data.get("pack", 1))
            self._world = str(data.get("world", ""))
        except (OSError, ValueError, KeyError, TypeError) as cause:
            raise ConfigError(
                f"{path}: unusable configuration of the navigators: {cause!r}"
            ) from cause
        if pack < 1:
            raise ConfigError(f"{path}: pack is {pack}; it must be 1 or more")
        self._peers = peers
        self._everybody = sorted({port for ports in peers.values() for port in ports})
        self._processes = -(-len(robots) // pack)
        settings = [read_node_settings(name, params) for name, params in robots]
        for robot in settings:
            _ = robot.sites  # now, and not once more in each child
        self.groups = [
            self._group(settings[start : start + pack], peers)
            for start in range(0, len(settings), pack)
        ]
        self._map = data.get("map")
        log_dir = data.get("log_dir")
        self.log_dir = Path(log_dir) if log_dir else None

    def newcomer(self, name: str, params: str) -> Group:
        """Return the group of a robot that comes, or comes back, while the swarm runs.

        Raises:
            SwarmError: If its parameters are unusable.
        """
        settings = read_node_settings(name, params)
        _ = settings.sites
        return self._group([settings], {name: self._peers.get(name, self._everybody)})

    def share_terrain(self) -> Conditions | None:
        """Derive now, before the fork, what all robots of a model need from the map.

        A robot that gets another map from the world derives its own.

        Returns:
            Room on the map; None without a map.

        Raises:
            SwarmError: If the map is unusable.
        """
        if self._map is None or not Path(self._map).is_file():
            return None
        robots = [robot for group in self.groups for robot in group.robots]
        return prepare(robots, load_map(self._map).upright(), self._processes, self._goals)

    def _group(self, robots: list[NodeSettings], peers: Mapping[str, Iterable[int]]) -> Group:
        if not ros_env.is_profile_ours() and not self._world:
            return Group(tuple(robots))
        ports = dict.fromkeys(port for settings in robots for port in peers[settings.name])
        path = self._folder / f"{robots[0].name}.xml"
        newest = HELPERS[-1] if self._world else ros_env.participant_id(self._everybody[-1])
        ros_env.write_profile(path, ports, newest + 1 + self._processes, self._world)
        return Group(tuple(robots), path)


def _ports(robot: Mapping[str, Any]) -> list[int]:
    return [int(port) for port in robot.get("peers") or (ros_env.world_port(),)]

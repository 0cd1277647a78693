"""Whether preferred lanes were learned for the world and the mission of a run."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from swarm_common.files.map_io import map_of_world
from swarm_common.model.zones import Zones
from swarm_mission.mission import Mission

WORLD, MISSIONS, ROBOTS = "world", "missions", "robots"  # keys of `Lanes.learned`


def made_for(world: Path, missions: Iterable[Mission], robots: int) -> dict[str, str]:
    """Return what lanes for some missions in a world say of them."""
    return {
        WORLD: _digest_of(world),
        MISSIONS: ", ".join(_mark(mission) for mission in missions),
        ROBOTS: str(robots),
    }


def lanes_remarks(zones: Zones, world: Path, mission: Mission | None) -> list[str]:
    """Return a sentence on what has changed since the lanes were learned, if anything.

    Args:
        mission: None where robots get their goals from somebody else.
    """
    if zones.lanes is None:
        return []
    learned, remarks = zones.lanes.learned, []
    if WORLD in learned and learned[WORLD] != _digest_of(world):
        remarks.append(
            "the world has changed since its lanes were learned; swarm-bench lanes makes new ones"
        )
    if mission is not None and MISSIONS in learned:
        theirs = learned[MISSIONS].split(", ")
        if _mark(mission) not in theirs:
            names = [each.partition(" ")[0] for each in theirs]
            theirs_are = f"for mission {', '.join(names)}"
            what = "before it changed" if mission.name in names else theirs_are
            remarks.append(
                f"the world's lanes were learned {what}; they may cost time in mission"
                f" {mission.name}: swarm-bench lanes makes new ones, --lanes none drives without"
            )
    return remarks


def _mark(mission: Mission) -> str:
    return f"{mission.name} {_hash(repr(mission).encode())}"


def _digest_of(world: Path) -> str:
    map_file = map_of_world(world)
    return _hash(world.read_bytes() + (b"" if map_file is None else map_file.read_bytes()))


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]

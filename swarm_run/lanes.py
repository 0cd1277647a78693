"""Whether preferred lanes were learned for the world and the mission of a run."""

from __future__ import annotations

import hashlib
from pathlib import Path

from swarm_common.files.map_io import map_of_world
from swarm_common.model.zones import Zones
from swarm_mission.mission import Mission

WORLD, MISSION, ROBOTS = "world", "mission", "robots"  # keys of `Lanes.learned`


def made_for(world: Path, mission: Mission, robots: int) -> dict[str, str]:
    """Return what lanes for a run say of it."""
    return {
        WORLD: _digest_of(world),
        MISSION: f"{mission.name} {_hash(repr(mission).encode())}",
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
    if mission is not None and MISSION in learned:
        theirs = learned[MISSION]
        if theirs != made_for(world, mission, 0)[MISSION]:
            name = theirs.partition(" ")[0]
            what = f"for mission {name}" if name != mission.name else "before it changed"
            remarks.append(
                f"the world's lanes were learned {what}; they may cost time in mission"
                f" {mission.name}: swarm-bench lanes makes new ones, --lanes none drives without"
            )
    return remarks


def _digest_of(world: Path) -> str:
    map_file = map_of_world(world)
    return _hash(world.read_bytes() + (b"" if map_file is None else map_file.read_bytes()))


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]

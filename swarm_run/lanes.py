"""Whether preferred lanes of a world are for a mission, and what changed since."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import replace
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


def lanes_for(
    zones: Zones, world: Path, mission: Mission | None, *, is_given: bool
) -> tuple[Zones, list[str]]:
    """Return the zones of a run, and a sentence on what changed since its lanes were learned.

    A world's own lanes are for the missions that they were learned for; in others they may cost
    time, and are left out.

    Args:
        mission: None where robots get their goals from somebody else.
        is_given: Whether the user gave the lanes for this run, which keeps them whatever it does.
    """
    if zones.lanes is None:
        return zones, []
    learned, remarks = zones.lanes.learned, []
    new_ones = "swarm-bench lanes makes new ones"
    if MISSIONS in learned and (mission is None or _mark(mission) not in learned[MISSIONS]):
        names = [each.partition(" ")[0] for each in learned[MISSIONS].split(", ")]
        has_changed = mission is not None and mission.name in names
        what = "before it changed" if has_changed else f"for mission {', '.join(names)}"
        if mission is not None and (has_changed or is_given):
            remarks.append(
                f"mission {mission.name}: the world's lanes were learned {what};"
                f" {'they may cost time here' if is_given else 'robots drive without'}: {new_ones}"
            )
        if not is_given:
            return replace(zones, lanes=None), remarks
    if WORLD in learned and learned[WORLD] != _digest_of(world):
        remarks.append(f"the world has changed since its lanes were learned; {new_ones}")
    return zones, remarks


def _mark(mission: Mission) -> str:
    return f"{mission.name} {_hash(repr(mission).encode())}"


def _digest_of(world: Path) -> str:
    map_file = map_of_world(world)
    return _hash(world.read_bytes() + (b"" if map_file is None else map_file.read_bytes()))


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]

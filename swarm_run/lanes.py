"""Whether preferred lanes of a world are for a mission, and what changed since."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from swarm_common.files.map_io import load_map, map_of_world
from swarm_common.model.zones import Lanes, Zones
from swarm_mission.mission import Mission

WORLD, MISSIONS, ROBOTS = "world", "missions", "robots"  # keys of `Lanes.learned`


def made_for(world: Path, missions: Iterable[Mission], robots: int) -> dict[str, str]:
    """Return what lanes for some missions in a world say of them."""
    return {
        WORLD: _digest_of(world),
        MISSIONS: ", ".join(_mark(mission) for mission in missions),
        ROBOTS: str(robots),
    }


def lanes_for(zones: Zones, mission: Mission | None, *, is_given: bool) -> Zones:
    """Return the zones of a run, without lanes that are for other missions.

    In missions that a world's own lanes were not learned for, they may cost time.

    Args:
        mission: None where robots get their goals from somebody else.
        is_given: Whether the user gave the lanes for this run, which keeps them whatever it does.
    """
    if is_given or zones.lanes is None or _are_for(zones.lanes, mission):
        return zones
    return replace(zones, lanes=None)


def lanes_remarks(
    zones: Zones, world: Path, mission: Mission | None, *, is_given: bool
) -> list[str]:
    """Return a sentence on what changed since lanes were learned, if anything.

    Args:
        zones: Those of the world, or with the lanes that were given.
        mission: As for `lanes_for`, like the next.
    """
    if zones.lanes is None:
        return []
    learned, remarks = zones.lanes.learned, []
    new_ones = "swarm-bench lanes makes new ones"
    is_fit = _are_for(zones.lanes, mission)
    if mission is not None and not is_fit:
        names = [mark.partition(" ")[0] for mark in _marks(zones.lanes)]
        has_changed = mission.name in names
        what = "before it changed" if has_changed else f"for mission {', '.join(names)}"
        if has_changed or is_given:
            remarks.append(
                f"mission {mission.name}: the world's lanes were learned {what};"
                f" {'they may cost time here' if is_given else 'robots drive without'}: {new_ones}"
            )
    is_used = is_given or is_fit
    if is_used and WORLD in learned and learned[WORLD] != _digest_of(world):
        remarks.append(f"the world has changed since its lanes were learned; {new_ones}")
    return remarks


def _are_for(lanes: Lanes, mission: Mission | None) -> bool:
    """Whether lanes are for a mission; those that nobody learned are for any."""
    marks = _marks(lanes)
    return not marks or (mission is not None and _mark(mission) in marks)


def _marks(lanes: Lanes) -> list[str]:
    return lanes.learned[MISSIONS].split(", ") if MISSIONS in lanes.learned else []


def _mark(mission: Mission) -> str:
    return f"{mission.name} {_hash(repr(mission).encode())}"


def _digest_of(world: Path) -> str:
    map_file = map_of_world(world)
    if map_file is None:
        return _hash(world.read_bytes())
    grid = load_map(map_file)  # of the file alone, a wall that is painted over would not be noticed
    place = repr((grid.resolution, grid.origin_x, grid.origin_y, grid.cells.shape))
    return _hash(world.read_bytes() + place.encode() + grid.cells.tobytes())


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]

"""Actors of an SDF world: an actor with a script becomes a walker, or a vehicle if it has a box."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

from swarm_common.model.errors import ConfigError, WorldError
from swarm_common.model.shapes import Box
from swarm_describe.files.values import floats_of, transform_of
from swarm_describe.worlds.actors import MAX_SPEED, Actors, VehicleSpec, WalkerSpec
from swarm_describe.worlds.shapes import shape_of
from swarm_describe.worlds.source import Source

Points = list[tuple[float, float]]
SAME_PLACE = 0.1  # [m] within which waypoints are one point of a path
DEFAULT_SPEED = 0.8  # [m/s] where the script takes no time


def actors_of(world: ET.Element, source: Source) -> Actors:
    """Return the actors of a world whose scripts move them."""
    walkers: list[WalkerSpec] = []
    vehicles: list[VehicleSpec] = []
    for index, actor in enumerate(world.findall("actor")):
        name = actor.get("name") or f"actor_{index + 1}"
        points, speed = _script(actor, name)
        if len(points) < 2:
            source.remark(f"actor {name} is left out: its script moves it nowhere")
            continue
        box = _box(actor, name, source)
        try:
            if box is None:
                walkers.append(WalkerSpec(name=name, path=tuple(points), speed=speed, pause=0.0))
            else:
                length, width, height = box.size
                vehicles.append(
                    VehicleSpec(
                        name=name,
                        path=tuple(points),
                        speed=speed,
                        pause=0.0,
                        length=length,
                        width=width,
                        height=height,
                    )
                )
        except ConfigError as cause:
            raise WorldError(f"<actor> {cause}") from cause
    return Actors(tuple(walkers), tuple(vehicles))


def _script(actor: ET.Element, name: str) -> tuple[Points, float]:
    """Return the loop that an actor's trajectories make, and the mean speed on it."""
    points: Points = []
    duration, length = 0.0, 0.0
    for trajectory in actor.findall("script/trajectory"):
        last: tuple[float, float, float] | None = None
        for waypoint in trajectory.findall("waypoint"):
            (time,) = floats_of(waypoint.find("time"), 1, "0", f"a <waypoint> of {name}")
            place = transform_of(waypoint.find("pose"), f"a <waypoint> of {name}")
            x, y = float(place[0, 3]), float(place[1, 3])
            if last is not None:
                step = math.dist((x, y), last[:2])
                if step > SAME_PLACE:  # turns on the spot take time, too, but are no way
                    duration += max(0.0, time - last[2])
                    length += step
            last = (x, y, time)
            if not points or math.dist((x, y), points[-1]) > SAME_PLACE:
                points.append((x, y))
    speed = length / duration if duration > 0.0 else DEFAULT_SPEED
    return _closed(points), min(MAX_SPEED, max(0.05, speed))


def _closed(points: Points) -> Points:
    """Return a loop; an actor that does not come back to its start returns the way it came."""
    if len(points) > 2 and math.dist(points[0], points[-1]) <= SAME_PLACE:
        return points[:-1]
    return points + points[-2:0:-1]


def _box(actor: ET.Element, name: str, source: Source) -> Box | None:
    """Return the first box among the collisions of an actor's links."""
    shapes = actor.findall("link/collision/geometry/*")
    boxes = [element for element in shapes if element.tag == "box"]
    if len(shapes) > len(boxes[:1]):
        what = "its first box" if boxes else "a person"
        source.remark(f"actor {name} has {len(shapes)} shapes; it is {what} here")
    shape = shape_of(boxes[0], name) if boxes else None
    return shape if isinstance(shape, Box) else None

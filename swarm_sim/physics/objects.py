"""Bodies that move besides robots and walkers: things that can be pushed, and vehicles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from swarm_common.model.records import CONTROL_PERIOD, FloatArray
from swarm_common.model.shapes import Transform
from swarm_describe.worlds.scene import Body
from swarm_sim.physics.actors import Vehicles
from swarm_sim.scene.section import Section, convex_hull, section_between

MAX_CORNERS = 32  # of an outline
PUSH_SPEED = 1.0  # [m/s] at which something that is pushed may move
NOWHERE = 1e6  # [m] place of the outlines of bodies that are not between the heights


class Objects:
    """Loose bodies, then vehicles, each with an outline between two heights.

    Attributes:
        loose: Bodies that can be pushed, and those that came at run time, as they were at first.
        vehicles: Vehicles on scripted paths.
        heights: [m] lower and upper end between which a body is an obstacle to robots.
    """

    def __init__(
        self, loose: Sequence[Body], vehicles: Vehicles, heights: tuple[float, float]
    ) -> None:
        """Put all where their bodies say."""
        self.loose = tuple(loose)
        self.vehicles = vehicles
        self.heights = heights
        self._places: list[Transform] = [body.world_from_body for body in loose]

    def __len__(self) -> int:
        """Return the number of objects."""
        return len(self.loose) + len(self.vehicles.specs)

    @property
    def names(self) -> list[str]:
        """Names of all objects, as collisions state them."""
        return [body.name for body in self.loose] + [spec.name for spec in self.vehicles.specs]

    @property
    def reaches(self) -> FloatArray:
        """(k,) [m] that each may move in a control period."""
        loose = [0.0 if body.is_static else PUSH_SPEED for body in self.loose]
        speeds = [s.speed + s.turn_speed * s.radius for s in self.vehicles.specs]
        reaches: FloatArray = CONTROL_PERIOD * np.array(loose + speeds)
        return reaches

    def add(self, body: Body) -> None:
        """Add a body behind the loose ones.

        Args:
            body: May be static, if it came at run time.
        """
        self.loose = (*self.loose, body)
        self._places.append(body.world_from_body)

    def remove(self, index: int) -> None:
        """Remove a loose body; those behind it move up."""
        self.loose = (*self.loose[:index], *self.loose[index + 1 :])
        del self._places[index]

    def place(self, index: int, world_from_body: Transform) -> None:
        """Update where a loose body is."""
        self._places[index] = world_from_body

    def place_of(self, index: int) -> Transform:
        """Return where a loose body is now."""
        return self._places[index]

    def bodies(self) -> list[Body]:
        """Return all objects where they are now."""
        loose = [
            replace(body, world_from_body=place)
            for body, place in zip(self.loose, self._places, strict=True)
        ]
        return loose + self.vehicles.bodies()

    def outlines(self) -> FloatArray:
        """Return the hull (k, MAX_CORNERS, 2) of each object, counter-clockwise."""
        packed = np.full((len(self), MAX_CORNERS, 2), NOWHERE)
        for index, body in enumerate(self.bodies()):
            pieces = section_between([body], *self.heights).outlines()
            if pieces:
                hull = convex_hull(np.vstack(pieces))
                few = np.linspace(0, len(hull) - 1e-9, MAX_CORNERS).astype(np.int64)
                padded = np.minimum(np.arange(MAX_CORNERS), len(hull) - 1)
                packed[index] = hull[few if len(hull) > MAX_CORNERS else padded]
        return packed

    def section(self, height: float) -> Section:
        """Return the section of the objects at a height."""
        return section_between(self.bodies(), height, height)

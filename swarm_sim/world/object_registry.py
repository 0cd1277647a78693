"""The objects in the world: which may come, go or be put elsewhere. Knows no ROS."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from swarm_common.model.errors import WorldError
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.shapes import Transform
from swarm_describe.worlds.scene import Body
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.object_placement import check_apart, check_object_place, height_range
from swarm_sim.world.request_checks import Reason, RefusedError

LIMIT = 500  # things at a time
MOST_SHAPES = 5000  # of all things
LONGEST_NAME = 64  # letters


class ObjectRegistry:
    """Lets things come and go; call what changes the world only between two ticks."""

    def __init__(self, world: ChangingWorld, robots: RobotNames | None = None) -> None:
        """Begin with the things that are there."""
        self._world = world
        self._robots = robots or RobotNames()
        self._spawned: set[str] = set()

    @property
    def names(self) -> list[str]:
        """Names of all things."""
        return [body.name for body in self._world.loose]

    @property
    def spawned(self) -> list[str]:
        """Names of the things that are there and were not at the start."""
        return [name for name in self.names if name in self._spawned]

    @property
    def folder(self) -> Path:
        """Folder of the world file, where models are searched, too."""
        return self._world.scene.directory

    def is_robots(self, name: str) -> bool:
        """Whether a name, or a namespace, is kept for a robot."""
        return self._robots.looks_like_one(name.removeprefix("/"))

    def place_of(self, name: str) -> Transform:
        """Return where a thing is."""
        return self._world.place_of(self._index(name))

    def spawn(
        self, name: str, rename: bool, body: Body, place: Transform, *, is_floored: bool
    ) -> str:
        """Register a thing; return its name.

        Args:
            name: Wanted name; empty for its model's.
            rename: Whether another name will do if that one is taken.
            body: The thing in its model's frame, see `read_object`.
            place: Place of its model's frame in the map frame.
            is_floored: Whether it is put on the ground, whatever the height of the place.
        """
        if len(self.names) >= LIMIT:
            raise RefusedError(Reason.FAILED, f"there are {LIMIT} things, which is the most")
        parts = sum(len(thing.parts) for thing in self._world.loose) + len(body.parts)
        if parts > MOST_SHAPES:
            raise RefusedError(
                Reason.FAILED,
                f"all things had {parts} shapes then; at most {MOST_SHAPES} are borne",
            )
        body = replace(body, name=self._free_name(name or body.name, rename or not name))
        self._check_finite(body.name, place)
        body = replace(body, world_from_body=place)
        if is_floored:
            raised = place.copy()
            raised[2, 3] -= height_range(body)[0]
            body = replace(body, world_from_body=raised)
        self._check_room(body)
        self._world.add_object(body)
        self._spawned.add(body.name)
        return body.name

    def remove(self, name: str) -> None:
        """Remove a thing."""
        self._world.remove_object(self._index(name))
        self._spawned.discard(name)

    def move(self, name: str, place: Transform) -> None:
        """Put a thing elsewhere."""
        index = self._index(name)
        self._check_finite(name, place)
        self._check_room(replace(self._world.loose[index], world_from_body=place), index)
        self._world.place_object(index, place)

    def check_homes(self) -> None:
        """Refuse a reset if one object would then be inside another.

        Raises:
            RefusedError: Naming both.
        """
        loose = self._world.loose
        for index, body in enumerate(loose):
            if body.name not in self._spawned:
                continue
            try:
                check_apart(body, (*loose[:index], *loose[index + 1 :]))
            except WorldError as error:
                raise RefusedError(
                    Reason.BAD_PLACE, f"{error}, where both were at first; nothing was moved"
                ) from error

    def send_home(self) -> None:
        """Put all things where they were at first; whether there is room is not checked here."""
        for index, body in enumerate(self._world.loose):
            self._world.place_object(index, body.world_from_body)

    def _index(self, name: str) -> int:
        if name not in self.names:
            known = ", ".join(self.names) or "nothing"
            raise RefusedError(Reason.UNKNOWN, f"there is no thing '{name}'; there are {known}")
        return self.names.index(name)

    def _free_name(self, name: str, rename: bool) -> str:
        if self.is_robots(name) or not is_name(name):
            raise RefusedError(
                Reason.NAME_INVALID,
                f"'{name[:LONGEST_NAME]}' is no name for a thing; expected 1 to {LONGEST_NAME} "
                f"letters that can be printed, and no robot's, like {self._robots.name_of(1)}",
            )
        taken = {body.name for body in (*self._world.scene.fixed, *self._world.objects())}
        taken |= set(self._world.walker_names)
        if name not in taken:
            return name
        number = 1
        while f"{name}_{number}" in taken:
            number += 1
        if not rename:
            raise RefusedError(
                Reason.NAME_TAKEN, f"there is a '{name}' already; '{name}_{number}' would be free"
            )
        return f"{name}_{number}"

    @staticmethod
    def _check_finite(name: str, place: Transform) -> None:
        if not np.isfinite(place).all():  # as the checks of requests make sure
            raise RefusedError(Reason.BAD_PLACE, f"the pose for '{name}' is not finite")

    def _check_room(self, body: Body, index: int | None = None) -> None:
        try:
            check_object_place(self._world, body, index)
        except WorldError as error:
            raise RefusedError(Reason.BAD_PLACE, str(error)) from error


def is_name(name: str) -> bool:
    """Whether a thing may be called so."""
    return 1 <= len(name) <= LONGEST_NAME and name.isprintable() and name.strip() != ""

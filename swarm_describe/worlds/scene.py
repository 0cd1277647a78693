"""A world's geometry after reading: bodies made of primitive shapes, and its named places."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from swarm_common.model.shapes import Part, Transform, Visual
from swarm_common.model.sites import Sites
from swarm_describe.worlds.actors import VehicleSpec, WalkerSpec

GROUND_GAP = 0.005  # [m] above ground from which something is an obstacle


@dataclass(frozen=True, slots=True)
class Body:
    """One link of the world file."""

    name: str  # ``model::link``, as Gazebo names it
    world_from_body: Transform  # where it is at the start
    parts: tuple[Part, ...]  # its collision shapes
    is_static: bool = True  # whether it can never move
    mass: float = 1.0  # [kg]; of no account for static bodies
    friction: float = 1.0  # Coulomb's coefficient against a surface of 1
    visuals: tuple[Visual, ...] = ()  # for viewers


@dataclass(frozen=True, slots=True)
class Scene:
    """Content of `worlds/<name>`."""

    name: str  # name of the folder or file, also that of the map
    file: Path  # the world file
    bodies: tuple[Body, ...]  # in file order
    # from `sites.yaml` beside the world file; empty if there is none
    sites: Sites = field(default_factory=Sites)
    # from `actors.yaml` beside it, and the actors of the world file
    walkers: tuple[WalkerSpec, ...] = ()
    vehicles: tuple[VehicleSpec, ...] = ()  # likewise
    decor: tuple[Body, ...] = ()  # bodies that are only to be seen
    notes: tuple[str, ...] = ()  # what of the world file is ignored, for the user

    @property
    def directory(self) -> Path:
        """Folder of the world file, for what it refers to."""
        return self.file.parent

    @property
    def fixed(self) -> tuple[Body, ...]:
        """The bodies that can never move: what a map shows."""
        return tuple(body for body in self.bodies if body.is_static)

    @property
    def loose(self) -> tuple[Body, ...]:
        """The bodies that can be pushed."""
        return tuple(body for body in self.bodies if not body.is_static)

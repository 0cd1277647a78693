"""All that robots can touch in the rigid-body engine: fixed bodies, objects, and walkers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pybullet

from swarm_common.model.records import FloatArray
from swarm_describe.worlds.scene import Body
from swarm_sim.physics.actors import Walkers
from swarm_sim.physics.bullet.fixed_bodies import (
    add_walker,
    let_robots_pass,
    mesh_tiles,
    solid_bodies,
)
from swarm_sim.physics.bullet.object_bodies import BulletObjects, add_piece, pieces_of
from swarm_sim.physics.objects import Objects
from swarm_sim.physics.planar import pack_polygons
from swarm_sim.scene.section import section_between

SOLVER_ITERATIONS = 10
CONTACT_BREAKING = 0.0005  # [m]
CONTACT_BREAKING_LOOSE = 0.006  # [m] where things can be pushed; with less they sink while sliding
NO_REACHES: FloatArray = np.zeros(0)


class Surroundings:
    """The bodies beside the robots, and their outlines for the broad phase.

    Attributes:
        bodies: pybullet's bodies of the objects.
    """

    def __init__(
        self, client: int, period: float, bodies: Sequence[Body], objects: Objects, walkers: Walkers
    ) -> None:
        """Add all bodies; call `release` before the robots come."""
        self._client, self._period = client, period
        self.objects, self.walkers = objects, walkers
        self._heights = objects.heights
        self._has_loose = len(objects.loose) > 0  # these may stand on what is high up
        self._configure()
        low = solid_bodies(bodies, *objects.heights)
        self._later = [] if self._has_loose else [b for b in bodies if not _is_in(b, low)]
        self._fixed: list[tuple[int, str]] = []  # of each outline of a fixed body: body, name
        self._outlines: list[FloatArray] = []
        self._standing: list[tuple[int, str]] = []  # of each body
        self._tiles: list[FloatArray] = []  # of the meshes among them
        self._tile_owners: list[tuple[int, str]] = []
        self._add_obstacles(bodies if self._has_loose else low)
        self.bodies = BulletObjects(client, objects)
        self.bodies.part(self._standing)
        self._walkers = [
            (add_walker(client, spec.radius, spec.height), spec.name) for spec in walkers.specs
        ]
        self.place_walkers()

    @property
    def is_still(self) -> bool:
        """Whether nothing here moves."""
        return not len(self.walkers) and not len(self.objects)

    @property
    def obstacles(self) -> list[tuple[int, str]]:
        """Body and name of each outline, then of each walker."""
        moving = list(zip(self.bodies.ids, self.objects.names, strict=True))
        return [*self._fixed, *moving, *self._walkers]

    @property
    def outlines(self) -> FloatArray:
        """Packed polygons (m, c, 2) of fixed bodies, then of objects."""
        moving = self.objects.outlines() if len(self.objects) else ()
        return pack_polygons([*self._outlines, *moving])

    @property
    def tiles(self) -> tuple[FloatArray, list[tuple[int, str]]]:
        """Bounds (k, 4) of the triangles of meshes that stand, in squares; their bodies, names."""
        return np.vstack([np.zeros((0, 4)), *self._tiles]), self._tile_owners

    @property
    def reaches(self) -> FloatArray:
        """[m] that each object may move in a control period."""
        return self.objects.reaches if len(self.objects) else NO_REACHES

    def add(self, body: Body) -> None:
        """Add an object behind all that can be pushed."""
        if not body.is_static and not self._has_loose:
            self._has_loose = True
            self._configure()
            self._add_obstacles(self._later)
        self.objects.add(body)
        self.bodies.add(body)

    def remove(self, index: int) -> None:
        """Remove an object; those behind it move up."""
        self.bodies.remove(index)
        self.objects.remove(index)

    def place_walkers(self) -> None:
        """Move the walkers' bodies to where the walkers are."""
        discs = self.walkers.discs.tolist()
        for spec, (body, _), disc in zip(self.walkers.specs, self._walkers, discs, strict=True):
            place = [disc[0], disc[1], spec.height / 2]
            pybullet.resetBasePositionAndOrientation(body, place, [0, 0, 0, 1], self._client)

    def _configure(self) -> None:
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self._period,
            numSolverIterations=SOLVER_ITERATIONS,
            enableConeFriction=0,
            contactBreakingThreshold=(
                CONTACT_BREAKING_LOOSE if self._has_loose else CONTACT_BREAKING
            ),
            deterministicOverlappingPairs=1,
            physicsClientId=self._client,
        )

    def _add_obstacles(self, bodies: Sequence[Body]) -> None:
        for body in bodies:
            is_low = bool(solid_bodies([body], *self._heights))
            for piece in pieces_of(body):
                identifiers = add_piece(self._client, piece)
                if not is_low:  # robots drive on it, or under it
                    let_robots_pass(self._client, identifiers)
                self._standing += [(identifier, body.name) for identifier in identifiers]
                tiles = mesh_tiles(piece, *self._heights)
                for identifier in identifiers:
                    self._tiles.append(tiles)
                    self._tile_owners += [(identifier, body.name)] * len(tiles)
                for outline in section_between([piece], *self._heights).outlines():
                    for identifier in identifiers:
                        self._outlines.append(outline)
                        self._fixed.append((identifier, body.name))


def _is_in(body: Body, bodies: Sequence[Body]) -> bool:
    return any(body is other for other in bodies)

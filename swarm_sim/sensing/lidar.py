"""The LiDARs of all robots: the section of the world at each scan plane, and when scans are due.

A LiDAR cuts all bodies at one height, so that it may hardly see some robots: `overlooked`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, LidarSpec, RobotSpec, Scan
from swarm_common.model.sensors import IDEAL, LidarErrors, SensorErrors
from swarm_describe.robots.description import RobotModel
from swarm_describe.worlds.scene import Body, Scene
from swarm_sim.physics.objects import Objects
from swarm_sim.scene.randomness import hash_words, normal, uniform
from swarm_sim.scene.section import Section, section_between
from swarm_sim.sensing import lidar_kernels

WORLD = -1  # owner of bodies that no robot carries
DROPOUT_WORD = 191  # what a random number is for
SWEEP_RAYS = 10  # that are taken at one time, if each ray has its own
NO_DISCS: FloatArray = np.zeros((0, 3))


class LidarGroup:
    """Robots with equal LiDARs, scanned together.

    What they can hit is the world's section at their scan plane, those of the other robots, and
    the walkers.
    """

    def __init__(
        self,
        spec: LidarSpec,
        members: Sequence[int],
        world: Section,
        robots: Sequence[Section],
        walkers: int = 0,
        errors: LidarErrors = IDEAL.lidar,
    ) -> None:
        """Prepare the arrays.

        Args:
            members: Indices of the robots that carry it.
            world: Fixed bodies at the height of the scan plane.
            robots: The section of every robot at that height, in its base_footprint.
            walkers: Number of discs that move on their own.
        """
        self.spec = spec
        self.objects: Objects | None = None  # what moves beside robots and walkers
        self._errors = errors
        self.members = np.array(members, np.int64)
        self.period_ticks = spec.period_ticks
        self._base_from_lidar = np.array([spec.x, spec.y, spec.yaw])
        segments = [section.segments() for section in robots]
        discs = [section.discs for section in robots]
        self._segments_base = np.vstack([np.zeros((0, 4)), *segments])
        self._discs_base = np.vstack([np.zeros((0, 3)), *discs])
        self._segment_owners = _owners(segments)
        self._disc_owners = _owners(discs)
        self._still_segments = len(world.segments())
        self._still_discs = len(world.discs)
        self._segments = np.vstack([world.segments(), self._segments_base])
        self._discs = np.vstack([world.discs, self._discs_base, np.zeros((walkers, 3))])
        self._first_walker = len(self._discs) - walkers
        still = [np.full(n, WORLD, np.int64) for n in (self._still_segments, self._still_discs)]
        self._owners = (
            np.concatenate([still[0], self._segment_owners]),
            np.concatenate([still[1], self._disc_owners, np.full(walkers, WORLD, np.int64)]),
        )
        self._rays = np.arange(spec.rays)
        self._true_ranges = np.empty((len(members), spec.rays))
        self._words = np.empty((len(members), spec.rays), np.uint64)
        self._past: deque[tuple[int, FloatArray]] = deque(maxlen=self.period_ticks)

    @property
    def kind(self) -> tuple[LidarSpec, LidarErrors]:
        """The LiDAR that all members have."""
        return self.spec, self._errors

    def remember(self, earlier: LidarGroup, poses: FloatArray) -> None:
        """Record where the robots were.

        Args:
            earlier: The group with the same LiDAR before a robot came or went.
            poses: x, y, yaw (n, 3) of all robots in the map frame; those new to `earlier` stood
                there.
        """
        for tick, known in earlier._past:
            self._past.append((tick, np.vstack([known, poses[len(known) :]])))

    def forget(self, robot: int, pose: FloatArray) -> None:
        """Record that a robot has always stood where it has been put."""
        for _, known in self._past:
            known[robot] = pose

    def note(self, poses: FloatArray, tick: int) -> None:
        """Remember where the robots were, for rays that are older than their scan.

        Args:
            tick: Current tick; a second call in one tick does nothing.
        """
        if self._errors.ray_time and (not self._past or self._past[-1][0] < tick):
            self._past.append((tick, poses.copy()))

    def scan(
        self, poses: FloatArray, seed: int, tick: int, walkers: FloatArray = NO_DISCS
    ) -> NDArray[np.float32]:
        """Return the measured ranges of all members.

        Args:
            tick: Current tick, at which the revolution ends.

        Returns:
            float32 (members, rays) [m]; inf where nothing is hit, -inf below `range_min` (REP 117),
            NaN where a ray is lost.
        """
        spec, errors = self.spec, self._errors
        if errors.ray_time and self._past:
            self._sweep(poses, walkers)
        else:
            self.cast(poses, walkers)
        ranges = np.empty((len(self.members), spec.rays), np.float32)
        words = self._words
        lidar_kernels.draw(seed, tick, self.members, words)
        limits = (spec.range_min, spec.range_max)
        sigma = spec.sigma
        if errors.sigma_share > 0.0:
            hits = np.isfinite(self._true_ranges)
            sigmas = np.hypot(sigma, errors.sigma_share * self._true_ranges[hits])
            self._true_ranges[hits] += sigmas * normal(words[hits])
            sigma = 0.0
        lidar_kernels.add_noise(self._true_ranges, words, sigma, *limits, ranges)
        if errors.dropout > 0.0:
            words = hash_words(seed, DROPOUT_WORD, tick, self.members[:, None], self._rays)
            ranges[uniform(words) < errors.dropout] = np.nan
        return ranges

    def _sweep(self, poses: FloatArray, walkers: FloatArray) -> None:
        """Cast a few rays at a time, each few where the robots were when it was their turn."""
        spec = self.spec
        earlier = self._past[0][1]
        turns = poses[:, 2] - earlier[:, 2]
        turns -= 2.0 * np.pi * np.round(turns / (2.0 * np.pi))
        swept = np.empty_like(self._true_ranges)
        for first in range(0, spec.rays, SWEEP_RAYS):
            last = min(spec.rays, first + SWEEP_RAYS)
            share = (0.5 * (first + last)) / spec.rays  # of the revolution that is over
            then = earlier + share * (poses - earlier)
            then[:, 2] = earlier[:, 2] + share * turns
            few = np.empty((len(self.members), last - first))
            self._cast(then, walkers, few, spec.angle_min + first * spec.angle_increment)
            swept[:, first:last] = few
        self._true_ranges[:] = swept

    def cast(self, poses: FloatArray, walkers: FloatArray = NO_DISCS) -> FloatArray:
        """Return the true ranges of all members.

        Returns:
            (members, rays) [m], inf beyond `range_max`; the array is reused by the next call.
        """
        self._cast(poses, walkers, self._true_ranges, self.spec.angle_min)
        return self._true_ranges

    def _cast(self, poses: FloatArray, walkers: FloatArray, out: FloatArray, angle: float) -> None:
        """Write the true ranges of the rays from an angle on, as many as `out` has columns."""
        if self.spec.upside_down:  # seen from above, the last ray comes first
            angle = -(angle + (out.shape[1] - 1) * self.spec.angle_increment)
        self._place(poses)
        self._discs[self._first_walker :] = walkers
        lidar_kernels.cast(
            compose(poses[self.members], self._base_from_lidar),
            self.members,
            (self._segments, self._owners[0]),
            (self._discs, self._owners[1]),
            (angle, self.spec.angle_increment, self.spec.range_max),
            out,
        )
        if self.spec.upside_down:
            out[:] = out[:, ::-1].copy()

    def _place(self, poses: FloatArray) -> None:
        """Move the robots' sections to their poses."""
        first, end = self._still_segments, self._still_segments + len(self._segments_base)
        segments, discs = self._segments[first:end], self._discs[self._still_discs :]
        lidar_kernels.carry(poses, self._segment_owners, self._segments_base, segments)
        lidar_kernels.carry(poses, self._disc_owners, self._discs_base, discs)
        if self.objects is not None:
            self._place_objects(self.objects, end)

    def _place_objects(self, objects: Objects, first: int) -> None:
        outlines = objects.section(self.spec.z).outlines()
        edges = [np.hstack([p, np.roll(p, -1, axis=0)]) for p in outlines]
        self._segments = np.vstack([self._segments[:first], *edges])
        owners = np.full(len(self._segments) - first, WORLD, np.int64)
        self._owners = (np.concatenate([self._owners[0][:first], owners]), self._owners[1])


class Lidars:
    """All LiDARs of a swarm."""

    def __init__(
        self,
        scene: Scene,
        specs: Sequence[RobotSpec],
        models: Sequence[Sequence[Body]],
        seed: int,
        walkers: int = 0,
        errors: Sequence[SensorErrors] | None = None,
        absent: Collection[int] = (),
    ) -> None:
        """Group robots with equal LiDARs.

        Args:
            errors: One per robot; None for ideal sensors.
            absent: Indices of robots that see nothing and are not seen.
        """
        self._seed = seed
        self._groups: list[LidarGroup] = []
        kinds = [
            (spec.lidar, IDEAL.lidar if errors is None else errors[i].lidar)
            for i, spec in enumerate(specs)
        ]
        present = [i for i in range(len(kinds)) if i not in absent]
        for kind in dict.fromkeys(kinds[i] for i in present):
            lidar, lidar_errors = kind
            members = [i for i in present if kinds[i] == kind]
            distinct = {id(bodies): bodies for bodies in models}
            cuts = {
                key: section_between(bodies, lidar.z, lidar.z) for key, bodies in distinct.items()
            }
            nothing = section_between([], lidar.z, lidar.z)
            robots = [
                nothing if i in absent else cuts[id(bodies)] for i, bodies in enumerate(models)
            ]
            world = section_between(scene.fixed, lidar.z, lidar.z)
            self._groups.append(LidarGroup(lidar, members, world, robots, walkers, lidar_errors))

    def remember(self, earlier: Lidars, poses: FloatArray) -> None:
        """Record where the robots were."""
        known = {group.kind: group for group in earlier._groups}
        for group in self._groups:
            if group.kind in known:
                group.remember(known[group.kind], poses)

    def forget(self, robot: int, pose: FloatArray) -> None:
        """Record that a robot has always stood where it has been put."""
        for group in self._groups:
            group.forget(robot, pose)

    def watch(self, objects: Objects) -> None:
        """Let the LiDARs see objects, wherever these are.

        Args:
            objects: Asked for their places at every scan; may be empty.
        """
        for group in self._groups:
            if len(objects) or group.objects is not None:  # the last one may have gone
                group.objects = objects

    def due(self, tick: int, poses: FloatArray, walkers: FloatArray = NO_DISCS) -> dict[int, Scan]:
        """Return the scans that are due at a tick, by index of the robot; see `measured`."""
        scans: dict[int, Scan] = {}
        for group, measured in self.measured(tick, poses, walkers):
            spec = group.spec
            limits = (spec.angle_min, spec.angle_increment, spec.range_min, spec.range_max)
            for member, ranges in zip(group.members.tolist(), measured, strict=True):
                scans[member] = Scan(tick, *limits, ranges)
        return scans

    def measured(
        self, tick: int, poses: FloatArray, walkers: FloatArray
    ) -> Iterator[tuple[LidarGroup, NDArray[np.float32]]]:
        """Yield each group whose scans are due at a tick, and their ranges, see `LidarGroup.scan`.

        Args:
            tick: Current tick; a LiDAR's scans are due at the multiples of its period.
        """
        for group in self._groups:
            if tick % group.period_ticks:
                group.note(poses, tick)
                continue
            ranges = group.scan(poses, self._seed, tick, walkers)
            group.note(poses, tick)
            yield group, ranges


def compose(poses: FloatArray, offset: FloatArray) -> FloatArray:
    """Return poses (n, 3) moved by an offset (3,) in each one's own frame."""
    points = moved(poses, np.broadcast_to(offset[:2], (len(poses), 2)))
    return np.column_stack([points, poses[:, 2] + offset[2]])


def moved(poses: FloatArray, points: FloatArray) -> FloatArray:
    """Return points (n, 2), each given in the frame of its pose (n, 3), in the poses' frame."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    return np.column_stack(
        [
            poses[:, 0] + cos * points[:, 0] - sin * points[:, 1],
            poses[:, 1] + sin * points[:, 0] + cos * points[:, 1],
        ]
    )


def _owners(arrays: Sequence[FloatArray]) -> NDArray[np.int64]:
    return np.repeat(np.arange(len(arrays)), [len(array) for array in arrays]).astype(np.int64)


def overlooked(
    seers: Sequence[RobotSpec],
    others: Sequence[RobotSpec],
    models: Mapping[str, RobotModel],
    margin: float,
) -> Iterator[str]:
    """Yield a sentence on each model of which another one's LiDAR sees nothing, or too little."""
    bodies = {other: models[other.model].bodies() for other in dict.fromkeys(others)}
    for seer in dict.fromkeys(seers):
        for other, parts in bodies.items():
            height = seer.lidar.z
            hidden = _reach_beyond(section_between(parts, height, height), other)
            lidar = f"the LiDAR of a {seer.model}, {height:.2f} m above the ground,"
            if math.isinf(hidden):
                yield f"{lidar} does not meet a {other.model}"
            elif hidden > margin:
                enough = math.ceil(hidden * 100) / 100
                yield (
                    f"{lidar} meets a {other.model} {hidden:.2f} m inside of its outline only "
                    f"(unless costmap.unknown_body_margin is {enough:g} or more)"
                )


def _reach_beyond(section: Section, robot: RobotSpec) -> float:
    """Return the distance [m] from a section to the corner farthest from it, inf if it is empty."""
    seen = shapely.union_all([shapely.Polygon(outline) for outline in section.outlines()])
    if seen.is_empty:
        return math.inf
    return float(shapely.distance(seen, shapely.points(robot.footprint)).max())

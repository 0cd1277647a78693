"""Episodes of all robots of a world, in arrays with a row for each; `gym` shows them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta

from swarm_bench.runs.episode import robot_named
from swarm_bench.runs.scenario import MOST_ROBOTS
from swarm_common.files.convert import convert
from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError
from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Mask
from swarm_common.model.schema import Positive, Seed, shown
from swarm_workbench import observation
from swarm_workbench.arena import Arena, OpenArena, ShieldedArena, grid_of
from swarm_workbench.episodes import GAP, Episodes
from swarm_workbench.frames import Frame, Painter
from swarm_workbench.observation import (
    REACHED,
    Observation,
    Observer,
    PolicyConfig,
    Rows,
    speeds_of,
)
from swarm_workbench.reward import Reward, StepOutcome, takes
from swarm_workbench.ways import ShortestWays
from swarm_workbench.world import World

FRESH_TRIES = 20  # episodes that are drawn for a robot among others that drive


class EnvOptions(PolicyConfig):
    """Options of an environment, beside those of what its policy sees.

    Attributes:
        robots: Number of robots, the most that take part.
        world: Name, file or folder; environments take a `World`, too.
        robot: Model of all robots.
        limit: [s] of an episode.
        shield: Whether robots drive inside space that they have reserved, through their stop
            filters.
        reward: Weights by term in place of the usual ones, such as `{"goal": 5.0}`, or a callable
            of a `StepOutcome` that returns n numbers; both are in `swarm_workbench.reward`.
        curriculum: Callable of the number of an episode, from 0, and a random generator of numpy;
            it returns what else would be options of `reset`.
        render_mode: How `render` shows a step; with None it shows nothing.
    """

    robots: Annotated[int, Meta(ge=1, le=MOST_ROBOTS)] = 4
    world: str = "doorway"
    robot: str = "turtlebot3_waffle"
    limit: Positive = 60.0
    shield: bool = False
    reward: Any = None
    curriculum: Any = None
    render_mode: Literal["human", "rgb_array"] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.curriculum is None or takes(self.curriculum, 2)):
            raise ConfigError(
                f"curriculum is {shown(self.curriculum)}; expected a callable of the number of an"
                " episode and a random generator"
            )


def options_of(robots: Any, world: Any, given: Mapping[str, Any]) -> EnvOptions:
    """Return the options of an environment.

    Raises:
        SwarmError: If one is unknown, or makes no sense.
    """
    known = EnvOptions.__struct_fields__
    for name in given:
        if name not in known:
            raise UnknownNameError("option", name, known)
    if isinstance(world, World | Path):
        world = str(world.file if isinstance(world, World) else world)
    plain: dict[str, Any] = {
        key: tuple(v) if isinstance(v, list) else v for key, v in given.items()
    }
    return EnvOptions(robots=robots, world=world, **plain)


class LearningTeam:
    """Episodes of all robots; m of them take part.

    Attributes:
        options: Options of the environment.
        bounds: Shape and limits of each part of an observation of one robot.
        most: (d,) largest entries of an action.
        has_begun: Whether there was a reset.
        is_done: (m,) who has reached its goal or touched something, and stands.
        terms: (m,) of each term of the last rewards.
    """

    def __init__(self, options: EnvOptions) -> None:
        """Read world and robot.

        Raises:
            SwarmError: If there is no such world or robot, or an option makes no sense.
        """
        self.options, count = options, options.robots
        self._spec = spec = robot_named(options.robot)
        radius = spec.circumscribed_radius
        self._arena: Arena = (ShieldedArena if options.shield else OpenArena)(
            options.world, options.robot
        )
        grid = grid_of(options.world)
        self._reward = Reward(options.reward)
        self._episodes = Episodes(grid, radius, count, options.curriculum)
        self._observer = Observer(options, spec, count)
        self._ways: ShortestWays | None = None
        if "way" in options.parts or self._reward.needs_ways:
            self._ways = ShortestWays(grid, radius, count)
        self._painter = None if options.render_mode is None else Painter(grid, spec)
        self.bounds = self._observer.bounds
        self._seconds = options.ticks * CONTROL_PERIOD
        self._limit = max(1, round(options.limit / self._seconds))
        self._scan_ticks = round(1.0 / (spec.lidar.rate * CONTROL_PERIOD))
        self._speeds = speeds_of(spec)
        self._size = 3 if spec.is_omni else 2
        self.most = np.ones(self._size) if options.normalise else self._speeds[: self._size]
        self._random = np.random.default_rng()
        self.has_begun = False
        self.is_done = np.zeros(count, np.bool_)
        self.terms: dict[str, FloatArray] = {}

    @property
    def count(self) -> int:
        """Number of robots that take part."""
        return len(self.is_done)

    @property
    def is_late(self) -> Mask:
        """Whose time is over (m,)."""
        late: Mask = self._ages >= self._limit
        return late

    def check_begun(self) -> None:
        """Raise a SwarmError if there is no episode yet, or it is over."""
        if not self.has_begun or bool((self.is_done | self.is_late).all()):
            raise SwarmError("no episode is under way: call reset()")

    def reset(self, seed: Any, options: Any) -> None:
        """Begin an episode.

        Raises:
            SwarmError: If seed or options make no sense, or a robot starts in a wall or another.
        """
        if seed is not None:
            value = seed.item() if isinstance(seed, np.integer) else seed
            self._random = np.random.default_rng(convert(value, Seed, "seed"))
        episode = self._episodes.draw(self._random, options)
        count = len(episode.starts)
        self.has_begun = False
        self._arena.reset(episode.starts, episode.people, int(self._random.integers(2**31)))
        self._check_starts(episode.starts)
        self.has_begun = True
        self.is_done = np.zeros(count, np.bool_)
        self._ages = np.zeros(count, np.int64)
        self._former = np.zeros((count, 3))
        self._goals = np.array(episode.goals)
        self._distances, self._left = np.zeros(count), np.zeros(count)
        self._begin(np.ones(count, np.bool_))

    def _check_starts(self, starts: FloatArray) -> None:
        gaps = self._arena.world.clearances
        for robot, (x, y, yaw) in enumerate(starts.tolist()):
            if gaps[robot].min() <= 0.0:
                thing = "another robot" if gaps[robot, 0] <= 0.0 else "a wall"
                raise ConfigError(
                    f"starts[{robot}] is ({x:g}, {y:g}, {yaw:g}): the robot stands in {thing};"
                    " choose another place"
                )

    def _begin(self, robots: Mask) -> None:
        """Begin episodes of robots that stand at their starts."""
        self.is_done[robots] = False
        self._ages[robots] = 0
        self._former[robots] = 0.0
        if self._ways is not None:
            for robot in np.flatnonzero(robots).tolist():
                self._ways.set_goal(robot, self._goals[robot])
        self._observer.restart(self._arena.ranges, robots)
        self._distances[robots] = self._gaps_to_goals()[robots]
        self._left[robots] = self._ways_left()[robots]

    def renew(self, robots: Mask) -> None:
        """Begin new episodes of some robots among the others, which drive on.

        Where robots reserve space, they stay where they are and get new goals only.
        """
        poses: dict[int, FloatArray] = {}
        for robot in np.flatnonzero(robots).tolist():
            for _ in range(FRESH_TRIES):
                episode = self._episodes.draw(self._random, None)
                if len(episode.starts) != self.count:
                    raise ConfigError(
                        f"the curriculum asks for {len(episode.starts)} robots of {self.count}:"
                        " their number is fixed where robots begin anew one by one"
                    )
                pose = episode.starts[robot]
                if not self._arena.can_place or self._is_free(pose, robot, poses):
                    break
            self._goals[robot] = episode.goals[robot]
            poses[robot] = pose
        if poses and self._arena.can_place:
            self._arena.place(poses)
        self._begin(robots)

    def _is_free(self, pose: FloatArray, robot: int, poses: Mapping[int, FloatArray]) -> bool:
        """Whether a start is away from the other robots and from people."""
        world = self._arena.world
        others = [poses.get(i, each)[:2] for i, each in enumerate(world.poses) if i != robot]
        places = np.array([*others, *world.walkers()[:, :2]]).reshape(-1, 2)
        gaps = np.hypot(*(places - pose[:2]).T)
        return bool(gaps.min(initial=np.inf) > 2.0 * self._spec.circumscribed_radius + GAP)

    def actions_of(self, given: Mapping[Any, Any]) -> FloatArray:
        """Return the actions (n, d) of some robots, checked.

        Args:
            given: Action of each by name or index.

        Raises:
            SwarmError: If one has not as many finite numbers as the robot takes.
        """
        shape = (len(given), self._size)
        try:
            actions = np.array([*given.values()], np.float64)
        except (TypeError, ValueError):
            actions = np.zeros(0)
        if actions.shape == shape and np.isfinite(actions).all():
            return actions
        for name, action in given.items():
            try:
                values = np.array(action, np.float64)
            except (TypeError, ValueError):
                values = np.zeros(0)
            if values.shape != (self._size,) or not np.isfinite(values).all():
                raise ConfigError(
                    f"the action of {name} is {shown(action)}; expected {self._size} finite numbers"
                )
        return np.zeros(shape)  # nobody acts

    def step(self, actions: FloatArray) -> tuple[FloatArray, Mask, Mask]:
        """Drive for a step by actions (m, d); return rewards, who is there, contacts, (m,) each."""
        shares = np.zeros((self.count, 3))
        shares[:, : self._size] = np.clip(actions / self.most, -1.0, 1.0)
        shares[self.is_done] = 0.0
        twists = shares * self._speeds
        was_done = self.is_done.copy()
        reached, contacts = np.zeros((2, self.count), np.bool_)
        for remaining in reversed(range(self.options.ticks)):
            looks = remaining < self._scan_ticks  # else a newer scan follows in this step
            contacts |= self._arena.step(twists, looks) & ~self.is_done
            distances = self._gaps_to_goals()
            reached |= (distances < REACHED) & ~self.is_done
            self.is_done |= reached | contacts
            twists[self.is_done] = 0.0
        self._ages += 1
        left = self._ways_left()
        rewards, self.terms = self._reward.of(
            StepOutcome(
                self._distances - distances,
                self._left - left,
                reached,
                contacts,
                np.minimum(self._arena.world.clearances.min(axis=1), 0.5),
                shares,
                self._former,
                self._seconds,
            )
        )
        for each in (rewards, *self.terms.values()):
            each[was_done] = 0.0
        self._distances, self._left, self._former = distances, left, shares
        self._observer.add(self._arena.ranges)
        return rewards, reached, contacts

    def observe(self) -> Observation:
        """Return what the robots see, by part."""
        arena, poses = self._arena, self._arena.world.poses
        ahead = self._goals if self._ways is None else self._ways.ahead[: self.count]
        numbers = np.arange(len(poses))
        return self._observer.observe(self._goals, ahead, poses, arena.twists, numbers)

    def seen(self) -> Observation | Rows:
        """Return what the robots see, as the options ask for."""
        seen = self.observe()
        return observation.flat(seen) if self.options.observation == "flat" else seen

    def frame(self) -> Frame:
        """Return a picture of the plan: (h, w, 3) uint8."""
        if self._painter is None or not self.has_begun:
            raise SwarmError("nothing to draw: make it with render_mode=…, and call reset() first")
        world = self._arena.world
        return self._painter.paint(world.poses, self._goals, world.walkers())

    def _gaps_to_goals(self) -> FloatArray:
        gaps: FloatArray = np.hypot(*(self._goals - self._arena.world.poses[:, :2]).T)
        return gaps

    def _ways_left(self) -> FloatArray:
        """Return the lengths [m] of the shortest ways to the goals; zeros if nobody asks."""
        if self._ways is None:
            return np.zeros(self.count)
        self._ways.follow(self._arena.world.poses)
        return self._ways.left[: self.count].copy()

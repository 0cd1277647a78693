"""Storms: seeded runs in which navigators fail and come back among crates and people.

The truth comes from the physics: contacts in which a robot that lives moves, and goals that robots
that live at the end missed although there was a way.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.storm.plan import FOR_EVER, Crate, Failure, Fault, StormPlan, draw_plan
from benchmarks.storm.reachable import Disc, Floor
from swarm_bench.runs.episode import RunOptions, build, nav_config, prepare
from swarm_bench.runs.harness import Harness
from swarm_bench.runs.methods import load_method
from swarm_bench.runs.scenario import Scenario
from swarm_common.model.breaches import Collision
from swarm_common.model.shapes import Box, Part, transform_from_xyz_rpy
from swarm_describe.worlds.scene import Body
from swarm_mission.itinerary import Itinerary
from swarm_mission.leg import Stop
from swarm_run.loop import InjectedFaults
from swarm_run.record.figures import rounded
from swarm_sim.world.changing_world import ChangingWorld

MOST_GOALS = 3  # of each robot's mission
TIME_LIMIT = 900.0  # [s]
MOVING = 0.03  # [m/s] from which a robot moves: faster than it creeps beside people
TURNING = 0.1  # [rad/s]
CRATE_HEIGHT = 0.4  # [m]
CRATE_TRIES = 8  # places looked at
CRATE_TICKS = 10  # in each tenth tick
WALL_ROOM = 0.02  # [m] beyond a robot's circle that a way must have to be one,
BODY_ROOM = 0.31  # [m] the same beside what only the LiDAR shows,
DEAD_ROOM = 0.5  # [m] and of a robot's centre beside a dead one's circle
GOAL_ROOM = 0.1  # [m] more of a goal, from which its robot may stand by the goal's tolerance


@dataclass(frozen=True, slots=True)
class StormRow:
    """A world that storms go through."""

    mission: str
    robots: int


ROWS = {
    "slim_blockage": StormRow("loading_route", 12),
    "crossing": StormRow("change_arms", 12),
    "pillars": StormRow("roam", 14),
    "warehouse": StormRow("warehouse_orders", 12),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class StormResult:
    """One storm."""

    world: str  # name
    robots: int  # swarm size
    seed: int  # of everything
    faults: dict[str, int]  # number of failures by kind
    crates: int  # that found room
    people: int  # who walked
    moving_contacts: int  # contact episodes in which a robot that lives moved when they began
    standing_contacts: int  # all others: somebody walked into a robot that stood, or a dead one
    first_contact: str  # where and when the first of `moving_contacts` was; empty without
    goals_sent: int  # goals of the robots that live at the end
    goals_reached: int  # of these
    goals_barred: int  # of these: missed, and there was no way to them any more
    first_miss: str  # who missed which goal although there was a way; empty if nobody did
    min_clearance: float | None  # [m] of any robot from anything
    sim_time: float  # [s] at the end
    wall_time: float  # [s] of the run
    trajectory_sha256: str  # of the true poses of all ticks

    @property
    def is_flawless(self) -> bool:
        """True if no living robot ran into anything, and all goals with a way were reached."""
        return (
            not self.moving_contacts and self.goals_reached + self.goals_barred == self.goals_sent
        )

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        return {"schema": 1, **rounded(dataclasses.asdict(self))}


@dataclass(frozen=True, slots=True)
class StormOptions:
    """One storm that is to run."""

    world: str
    seed: int

    @property
    def robots(self) -> int:
        """Swarm size."""
        return ROWS[self.world].robots

    @property
    def run_options(self) -> RunOptions:
        """The run beneath it: perfect sensors, with LiDARs."""
        row = ROWS[self.world]
        scenario = Scenario(
            name=f"storm in {self.world}",
            world=self.world,
            mission=row.mission,
            robots=(self.robots,),
            with_lidar=True,
            time_limit={self.robots: TIME_LIMIT},
            stall_limit=TIME_LIMIT,
        )
        return RunOptions(scenario=scenario, robots=self.robots, seed=self.seed)


class Storm(Harness):
    """A storm in progress; `contacts` are those in which a living robot moved."""

    def __init__(self, options: StormOptions, plan: StormPlan | None = None) -> None:
        """Build world and robots; without a plan, draw one from the seed."""
        run_options = options.run_options
        setup, _ = prepare(run_options)
        self.floor = Floor(setup.grid)
        self.plan = plan or draw_plan(options.seed, options.robots, self.floor, setup.starts)
        self._mute: set[int] = set()
        self._deaf: set[int] = set()
        super().__init__(
            run_options,
            faults=InjectedFaults(mute=self._mute, deaf=self._deaf),
            episode=build(
                run_options,
                world_class=ChangingWorld,
                walkers=self.plan.walkers,
                most_goals=MOST_GOALS,
            ),
        )
        self._storm = options
        self._rng = np.random.default_rng((options.seed, 13))
        self._waiting = sorted(self.plan.crates, key=lambda crate: crate.tick)
        self._crates: list[Disc] = []
        self._down: dict[int, Fault] = {}  # robots that are killed or hung
        self._was_moving = np.zeros(options.robots, np.bool_)
        self.contacts: list[Collision] = []

    @property
    def is_over(self) -> bool:
        """True if all goals are settled of robots that live or will live again."""
        return all(
            itinerary.is_over or index in self._lost
            for index, itinerary in enumerate(self.episode.itineraries)
        )

    @property
    def _lost(self) -> set[int]:
        return {robot for robot, fault in self._down.items() if fault.end >= FOR_EVER}

    def begin(self, tick: int) -> None:
        """Let everything begin and end that does at a tick."""
        on = [fault for fault in self.plan.faults if fault.is_on(tick)]
        for kind, robots in ((Failure.MUTE, self._mute), (Failure.DEAF, self._deaf)):
            robots.clear()
            robots.update(fault.robot for fault in on if fault.failure is kind)
        down = {f.robot: f for f in on if f.failure in (Failure.KILLED, Failure.HUNG)}
        for robot, fault in self._down.items():
            if robot not in down and fault.failure is Failure.KILLED:
                self._start_anew(robot, tick)
        self._down = down
        self.dead.clear()
        self.dead.update(down)
        if tick % CRATE_TICKS == 0 and self._waiting and self._waiting[0].tick <= tick:
            if self._put(self._waiting[0]):
                self._waiting.pop(0)
        speeds = [twist for _, twist in self.episode.world.ground_truth()]
        self._was_moving = np.array(
            [math.hypot(s.vx, s.vy) > MOVING or abs(s.wz) > TURNING for s in speeds]
        )

    def _start_anew(self, robot: int, tick: int) -> None:
        """Give a robot a new navigator, which knows the map and where it is, but nobody else."""
        episode, options = self.episode, self.options
        spec = episode.world.specs[robot]
        make = load_method(options.method)
        episode.drivers[robot] = make(
            nav_config(options, spec),
            spec,
            episode.setup.grid,
            episode.setup.scene.sites,
            robot + 1,
            episode.world.ground_truth()[robot][0],
        )
        itinerary = episode.itineraries[robot]
        if isinstance(itinerary, Itinerary) and not itinerary.is_over:
            itinerary.on_taken_over()
            self._send(robot, itinerary.on_free_again(tick))

    def _put(self, crate: Crate) -> bool:
        """Put a crate where nobody loses its way to a goal; return whether there was room."""
        world = self.episode.world
        assert isinstance(world, ChangingWorld)
        radius = crate.side / math.sqrt(2.0)
        kept = [*self._crates, *self._stuck()]
        led_to = self._led_to(kept)
        for _ in range(CRATE_TRIES):
            x, y = self.floor.draw(self._rng, radius + 0.05)
            gaps = np.hypot(world.poses[:, 0] - x, world.poses[:, 1] - y)
            if gaps.min() < radius + 1.0:
                continue
            disc = (x, y, radius + self._body + BODY_ROOM)
            if not self._led_to([*kept, disc]) >= led_to:
                continue
            box = Part(Box((crate.side, crate.side, CRATE_HEIGHT)), np.eye(4))
            place = transform_from_xyz_rpy(x, y, CRATE_HEIGHT / 2, 0.0, 0.0, crate.yaw)
            name = f"crate_{len(self._crates) + 1}"
            world.add_object(Body(f"{name}::link", place, (box,), is_static=True))
            self._crates.append(disc)
            return True
        return False

    def _stuck(self) -> list[Disc]:
        room = DEAD_ROOM + self._body
        return [(*self.episode.world.poses[robot, :2].tolist(), room) for robot in self._lost]

    @property
    def _body(self) -> float:
        return max(spec.circumscribed_radius for spec in self.episode.world.specs)

    def _led_to(self, discs: Sequence[Disc]) -> set[tuple[int, int]]:
        """Return (robot, goal), both as indices, of all goals that there is a way to."""
        labels = self._regions(discs)
        return {
            (index, number)
            for index, goals in enumerate(self.episode.stops)
            for number, goal in enumerate(goals)
            if self._leads(labels, index, goal)
        }

    def _regions(self, discs: Sequence[Disc]) -> NDArray[np.int16]:
        wider = [(x, y, radius + GOAL_ROOM) for x, y, radius in discs]
        return self.floor.components(self._body + WALL_ROOM, wider)

    def _leads(self, labels: NDArray[np.int16], robot: int, goal: Stop) -> bool:
        x, y = self.episode.world.poses[robot, :2].tolist()
        return self.floor.connected(labels, (x, y), (goal.pose_map.x, goal.pose_map.y))

    def on_contacts(self, collisions: Sequence[Collision]) -> None:
        """Keep those in which a living robot moved."""
        names = self.episode.world.names
        for collision in collisions:
            members = [names.index(name) for name in collision.robots]
            if any(self._was_moving[m] for m in members if m not in self._down):
                self.contacts.append(collision)

    def _missed(self) -> list[tuple[int, Stop]]:
        """Return the goals that robots that live at the end did not reach."""
        missed = []
        for index, goals in enumerate(self.episode.stops):
            rest = list(goals)
            for outcome in self.episode.itineraries[index].outcomes:
                if outcome.reached:
                    rest.remove(outcome.stop)
            if index not in self._lost:
                missed += [(index, goal) for goal in rest]
        return missed

    def storm(self) -> StormResult:
        """Run until all goals are settled or the time is up; return the result."""
        result = self.run()
        labels = self._regions([*self._crates, *self._stuck()])
        missed = self._missed()
        owed = [(index, goal) for index, goal in missed if self._leads(labels, index, goal)]
        sent = sum(len(goals) for i, goals in enumerate(self.episode.stops) if i not in self._lost)
        return StormResult(
            world=self._storm.world,
            robots=self._storm.robots,
            seed=self._storm.seed,
            faults=self.plan.counts,
            crates=len(self._crates),
            people=len(self.plan.walkers),
            moving_contacts=len(self.contacts),
            standing_contacts=len(self.episode.world.collisions) - len(self.contacts),
            first_contact=str(self.contacts[0]) if self.contacts else "",
            goals_sent=sent,
            goals_reached=sent - len(missed),
            goals_barred=len(missed) - len(owed),
            first_miss=self._miss(*owed[0]) if owed else "",
            min_clearance=result.min_clearance,
            sim_time=result.sim_time,
            wall_time=result.wall_time,
            trajectory_sha256=result.trajectory_sha256,
        )

    def _miss(self, index: int, goal: Stop) -> str:
        """Return the robot that missed a goal, and its state."""
        status = self.episode.drivers[index].status()
        reasons = [o.reason for o in self.episode.itineraries[index].outcomes if o.reason]
        pose = status.pose_map
        return (
            f"{self.episode.world.names[index]} missed {goal.name}, is {status.state} "
            f"{status.detail} at ({pose.x:.2f}, {pose.y:.2f}) {'; '.join(reasons[:1])}"
        )


def run_storm(options: StormOptions) -> StormResult:
    """Run one storm; a function, so that other processes can."""
    return Storm(options).storm()

"""The robots in the world: which may come, go or be put elsewhere. Knows no ROS."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import shapely

from swarm_common.model.errors import SwarmError, WorldError
from swarm_common.model.grid import FREE, Grid
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.robot_names import MOST, RobotNames
from swarm_describe.robots.loading import Robot
from swarm_sim.maps.spawn import spawn_poses
from swarm_sim.world.changing_world import ChangingWorld
from swarm_sim.world.object_placement import outline_of
from swarm_sim.world.request_checks import PlacementArea, Reason, RefusedError
from swarm_sim.world.robot_placement import check_height, check_robot_place

LIMIT = 200  # robots present at a time
MOST_EVER = 1000  # robots of a run, those that are gone included: each keeps its row


@dataclass(frozen=True, slots=True)
class Arrival:
    """A robot that has come."""

    index: int  # in the world
    name: str  # namespace
    number: int  # in its name and in its beacons
    model: str  # name or path, as it was asked for
    robot: Robot  # all about the model
    pose_map: Pose  # where it stands


class RobotRegistry:
    """Lets robots come and go; call what changes the world only between two ticks."""

    def __init__(
        self,
        world: ChangingWorld,
        grid: Grid,
        homes: Sequence[Pose],
        spawn: str,
        names: RobotNames | None = None,
    ) -> None:
        """Begin with those that are there.

        Args:
            spawn: Name of the spawn in the world's sites, empty for the default one.
            names: Names of all robots, also of those that come; None for the usual ones.
        """
        self._world = world
        self._grid = grid
        self._reach = PlacementArea.of(grid)
        self._homes = list(homes)
        self._spawn = spawn
        self._first = len(homes)  # robots that came with the world
        self._names = names or RobotNames()
        self._highest = max(map(self._names.number_of, world.names), default=0)

    # Robots present

    @property
    def robots(self) -> list[str]:
        """Names of the robots that are there."""
        return [self._world.names[robot] for robot in self._world.present]

    def robot(self, name: str) -> int:
        """Return the index of a robot that is there."""
        for robot in self._world.present:
            if self._world.names[robot] == name:
                return robot
        raise self._unknown(name)

    def _unknown(self, name: str) -> RefusedError:
        things = [body.name for body in self._world.loose]
        known = ", ".join([*self.robots, *things]) or "nobody"
        return RefusedError(Reason.UNKNOWN, f"there is no '{name}'; there are {known}")

    # Coming and going

    def spawn(
        self, name: str, rename: bool, model: str, robot: Robot, pose: Pose | None
    ) -> Arrival:
        """Register a robot; return its index, name, model and place.

        Args:
            name: One of the run, or empty for that with the next free number.
            rename: Whether another name will do if that one is taken.
            pose: Place in the map frame, None for a free one of the world's start area.
        """
        if len(self._world.present) >= LIMIT:
            raise RefusedError(Reason.FAILED, f"there are {LIMIT} robots, which is the most")
        if len(self._world.specs) >= MOST_EVER:
            raise RefusedError(
                Reason.FAILED, f"{MOST_EVER} robots have been here, the most of a run"
            )
        name = self._free_name(name, rename)
        self._check_model(robot)
        known = self._world.names.index(name) if name in self._world.names else None
        if known is not None and not robot.spec.is_same_model(self._world.specs[known]):
            before = self._world.specs[known].model
            raise RefusedError(
                Reason.NAME_TAKEN, f"{name} was a {before} in this run; take another name"
            )
        place = self._free_place(robot.spec) if pose is None else pose
        self._check_place(robot.spec, place)
        number = self._names.number_of(name)
        if known is None:
            index = self._world.add(name, number, robot.spec, robot.model, place)
            self._homes.append(place)
        else:
            index = known
            self._world.readmit(index, number, place)
            self._homes[index] = place
        self._highest = max(self._highest, number)
        return Arrival(index, name, number, model, robot, place)

    def remove(self, name: str) -> int:
        """Remove a robot; return its index."""
        robot = self.robot(name)
        self._world.remove(robot, self._names.number_of(name))
        return robot

    def move(self, name: str, pose: Pose) -> int:
        """Put a robot elsewhere; return its index."""
        robot = self.robot(name)
        self._check_place(self._world.specs[robot], pose, robot)
        self._put(robot, pose)
        return robot

    def send_home(self) -> list[tuple[int, Pose]]:
        """Put all robots where they were at first; return which, and where.

        Things have to be put there next: their first places are checked, not their present ones.
        """
        homes = [(robot, self._homes[robot]) for robot in self._world.present]
        self._check_homes(homes)
        for robot, home in homes:
            self._put(robot, home)
        return homes

    def settle(self, robot: int) -> None:
        """Let a robot be heard again that knows where it was put."""
        self._world.let_speak(self._number_of(robot))

    @property
    def spawned(self) -> list[str]:
        """Names of the robots that are there and were not at the start."""
        return [self._world.names[i] for i in self._world.present if i >= self._first]

    def _number_of(self, robot: int) -> int:
        return self._names.number_of(self._world.names[robot])

    def _put(self, robot: int, pose: Pose) -> None:
        self._world.speak_for(robot, self._number_of(robot), pose)
        self._world.place(robot, pose)

    # Checks

    def _free_name(self, name: str, rename: bool) -> str:
        if name and not self._names.number_of(name):
            raise RefusedError(
                Reason.NAME_INVALID,
                f"'{name}' is no name for a robot of this run; expected {self._names.expected}",
            )
        world = self._world
        taken = {*self.robots, *world.walker_names}
        bodies = (*world.scene.fixed, *world.objects())
        taken |= {body.name.partition("::")[0] for body in bodies}  # models
        if name and name not in taken:
            return name
        following = self._following(taken)
        if name and not rename:
            raise RefusedError(
                Reason.NAME_TAKEN, f"there is a {name} already; {following} would be free"
            )
        return following

    def _following(self, taken: Collection[str]) -> str:
        for number in range(self._highest + 1, MOST + 1):
            name = self._names.name_of(number)
            if name not in taken and self._names.number_of(name) == number:
                return name
        raise RefusedError(Reason.FAILED, f"no number up to {MOST} is left for another robot")

    def _check_model(self, robot: Robot) -> None:
        try:
            check_height(self._world, robot.spec)
            self._world.check_model(robot.spec, robot.model)
        except SwarmError as error:
            raise RefusedError(Reason.BAD_MODEL, str(error)) from error
        for known in self._world.specs:
            if known.model == robot.spec.model and not known.is_same_model(robot.spec):
                raise RefusedError(
                    Reason.BAD_MODEL,
                    f"another model of this run is called '{known.model}', too; "
                    "write another name into one's robot.yaml, model: ...",
                )

    def _check_place(self, spec: RobotSpec, pose: Pose, robot: int | None = None) -> None:
        self._reach.check((pose.x, pose.y))
        try:
            check_robot_place(self._world, spec, pose, robot)
        except WorldError as error:
            raise RefusedError(Reason.BAD_PLACE, str(error)) from error
        row, column = self._grid.cell_of(pose.x, pose.y)
        inside = self._grid.contains(pose.x, pose.y)
        if not inside or self._grid.cells[row, column] != FREE:
            raise RefusedError(
                Reason.BAD_PLACE, f"the map shows no free space at ({pose.x:.2f}, {pose.y:.2f})"
            )

    def _free_place(self, spec: RobotSpec) -> Pose:
        world = self._world
        count = len(world.specs) + 1
        while count:
            try:
                places = spawn_poses(world.scene, spec, count, self._spawn)
                break
            except WorldError:
                count -= 1
        else:
            places = []
        for place in places:
            try:
                check_robot_place(world, spec, place)
            except WorldError:
                continue
            return place
        raise RefusedError(
            Reason.BAD_PLACE, "no place of the start area is free now; wait, or give a pose"
        )

    def _check_homes(self, homes: Sequence[tuple[int, Pose]]) -> None:
        world = self._world
        things = [(body.name, outline_of(body, world.heights)) for body in world.loose]
        taken = [shapely.Point(x, y).buffer(radius) for x, y, radius in world.walkers().tolist()]
        for robot, home in homes:
            radius = world.specs[robot].circumscribed_radius
            place = shapely.Point(home.x, home.y)
            names = [name for name, outline in things if outline.distance(place) < radius]
            if names or any(other.distance(place) < radius for other in taken):
                by = f" by '{names[0]}'" if names else ""
                raise RefusedError(
                    Reason.BAD_PLACE,
                    f"the start of {world.names[robot]}, ({home.x:.2f}, {home.y:.2f}), is "
                    f"taken{by}; nothing was moved",
                )
            taken.append(place.buffer(radius))

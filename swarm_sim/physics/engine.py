"""Interface of a physics engine; `planar` and `bullet` implement it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from swarm_common.model.records import FloatArray, RobotSpec
from swarm_common.model.shapes import Transform
from swarm_describe.robots.description import RobotModel
from swarm_describe.worlds.scene import Body

NEAR = 0.5  # [m] clearances beyond this are not measured
NEAR_MISS = 0.03  # [m] closer than this without contact is a near miss


@dataclass(frozen=True, slots=True)
class Touch:
    """A contact seen during a control period."""

    robot: int  # index of the robot
    other: int  # index of the other robot, larger than `robot`; -1 for an obstacle
    obstacle: str  # name of the obstacle, empty if `other` is a robot
    x: float  # [m] where
    y: float  # [m] where
    step: int  # physics step within the period


@dataclass(frozen=True, slots=True)
class NearPair:
    """A pair that is closer than `NEAR_MISS`; `gap` [m], the rest as in `Touch`."""

    robot: int
    other: int
    obstacle: str
    gap: float


class Engine(Protocol):
    """Bodies and motors; arrays have one row per robot."""

    poses: FloatArray  # (n, 3) true x, y, yaw of base_footprint
    twists: FloatArray  # (n, 3) true forward, turning and leftward speed
    travels: FloatArray  # (n, 2) [m] forwards and to the left, as the wheels report it
    yaws_gyro: FloatArray  # (n,) [rad] integrated gyro, not wrapped

    @property
    def clearances(self) -> FloatArray:
        """(n, 2) to the nearest robot, obstacle; inf beyond NEAR."""
        ...

    @property
    def approaches(self) -> list[NearPair]:
        """Pairs closer than NEAR_MISS at the end of the control period."""
        ...

    def advance(self, targets: FloatArray) -> list[Touch]:
        """Run one control period; return its contacts, also those that have lasted since before.

        Args:
            targets: Forward, turning and leftward speed [m/s, rad/s, m/s] of base_footprint, one
                row per robot.
        """
        ...

    def joint_state(self, robot: int) -> tuple[list[str], list[float], list[float]]:
        """Return the state of a robot's wheel joints.

        Returns:
            Names, the left ones from front to rear, then the right ones; angles [rad]; speeds
            [rad/s].
        """
        ...

    def add(self, spec: RobotSpec, model: RobotModel | None, pose: FloatArray) -> None:
        """Add a robot, which stands at a pose (3,).

        Args:
            model: None for an engine that needs no bodies.
        """
        ...

    def place(self, robot: int, pose: FloatArray) -> None:
        """Put a robot elsewhere, where it stands; wheels and gyro do not notice."""
        ...

    def restart(self, robot: int) -> None:
        """Let what a robot's wheels and gyro report begin at 0 again."""
        ...

    def place_object(self, index: int, place: Transform) -> None:
        """Put something that can be pushed elsewhere."""
        ...

    def add_object(self, body: Body) -> None:
        """Add a thing behind all that can be pushed; a static one stays where it is."""
        ...

    def remove_object(self, index: int) -> None:
        """Remove a thing; those behind it move up."""
        ...

    def close(self) -> None:
        """Release what the engine holds outside Python."""
        ...

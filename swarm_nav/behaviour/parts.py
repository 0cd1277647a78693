"""The parts of one robot: rules decide with them, and beacon and status tell of them."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.goal_manager import GoalManager
from swarm_nav.behaviour.state_machine import StateMachine
from swarm_nav.traffic.arbiter import Arbiter
from swarm_nav.traffic.departure import Departure
from swarm_nav.traffic.gate import Gate
from swarm_nav.traffic.holding import HoldingPattern
from swarm_nav.traffic.lease import Lease
from swarm_nav.traffic.right_of_way import RightOfWay
from swarm_nav.traffic.robot_state import RobotState
from swarm_nav.traffic.senses import Senses
from swarm_nav.traffic.speed_near_people import NOBODY_NEAR, People


@dataclass(slots=True)
class Parts:
    """The parts that decide for one robot.

    Attributes:
        people: Near the robot, at the end of the last tick in which it could drive.
        is_active: Whether the robot may drive.
    """

    robot: RobotState
    sites: Sites
    state_machine: StateMachine
    goal_manager: GoalManager
    right: RightOfWay
    departure: Departure
    lease: Lease
    gate: Gate
    holding: HoldingPattern
    senses: Senses
    arbiter: Arbiter
    people: People = NOBODY_NEAR
    is_active: bool = True

    def adopt_pose(self, pose_map: Pose) -> None:
        """Continue from a pose that is elsewhere; claims made at the old one are dropped."""
        s = self.robot
        if pose_map.distance(s.pose) > s.config.traffic.safety_margin:
            self.senses.listen_anew()  # the owner of the space there is not known yet
        s.pose = pose_map
        self.arbiter.hold_place()

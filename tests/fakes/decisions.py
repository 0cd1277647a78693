"""Rules tried one by one: what each proposes is applied as the arbiter does."""

from collections.abc import Callable

from swarm_common.model.records import Twist
from swarm_nav.behaviour.behaviors import Behavior
from swarm_nav.behaviour.goal_manager import GoalManager
from swarm_nav.behaviour.route import Route
from swarm_nav.control.controller import Controller
from swarm_nav.interfaces import Proposal
from swarm_nav.traffic.arbiter import Arbiter
from swarm_nav.traffic.departure import Departure
from swarm_nav.traffic.held_space_rules import KeepApart, StopBeforeObstacle
from swarm_nav.traffic.holding import HoldingPattern
from swarm_nav.traffic.right_of_way import RightOfWay
from swarm_nav.traffic.robot_state import RobotState
from swarm_nav.traffic.single_lanes import SingleLanes


def act(robot: RobotState, proposal: Proposal | None) -> None:
    """Apply a proposal, if there is one."""
    if proposal is not None:
        arbiter_of(robot).apply(proposal)


def arbiter_of(robot: RobotState) -> Arbiter:
    return Arbiter(robot, SingleLanes())


def push(right: RightOfWay, robot: RobotState) -> bool:
    """Let right of way decide; return whether the robot makes way or steps back."""
    act(robot, right.propose(robot))
    return right.is_yielding


def leave(departure: Departure, robot: RobotState, is_idle: bool) -> bool:
    """Let departure decide; return whether the robot is on its way out."""
    act(robot, departure.propose(robot, is_idle))
    return departure.is_leaving


def hold(holding: HoldingPattern, robot: RobotState, kept_free: Callable[[], None]) -> None:
    act(robot, holding.propose(robot, kept_free))


def drive(route: Route, robot: RobotState, goal_manager: GoalManager) -> None:
    assert goal_manager.task is not None
    proposal = route.propose(goal_manager.task)
    for event in proposal.events if proposal is not None else ():
        goal_manager.apply(event)
    act(robot, proposal)


def guard(robot: RobotState) -> None:
    for rule in (KeepApart(), StopBeforeObstacle()):
        act(robot, rule.propose(robot))


def step(behavior: Behavior, robot: RobotState, controller: Controller) -> Twist:
    """Let a behaviour decide; return the twist."""
    arbiter = arbiter_of(robot)
    arbiter.winner = behavior.propose(robot)
    arbiter.apply(arbiter.winner)
    return arbiter.follow(controller, may_back=False)

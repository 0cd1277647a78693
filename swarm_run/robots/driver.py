"""Driver of one robot through its itinerary: goals out, results and status in."""

from __future__ import annotations

import math
from typing import Any, Protocol

from nav2_msgs.action import ComputePathToPose, NavigateToPose
from rclpy.node import Node
from swarm_interfaces.msg import Mission as MissionMsg
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware.ros_io import LATCHED, pose_stamped, start_text, tick_of, time_msg
from swarm_common.model.errors import ON_THIS_MAP
from swarm_common.model.records import CONTROL_PERIOD
from swarm_mission.itinerary import Itinerary, ItineraryState, NextGoal, StopOutcome
from swarm_run.robots.client import RobotCommander
from swarm_run.robots.status_check import StatusCheck
from swarm_run.robots.task import Task, TaskResult

SAME_GOAL = 1e-3  # [m]
OFF_THE_MAP = (
    ComputePathToPose.Result.START_OUTSIDE_MAP,
    ComputePathToPose.Result.GOAL_OUTSIDE_MAP,
)


class Listener(Protocol):
    """Receives the progress of a mission."""

    def on_sent(self, driver: RobotDriver, order: NextGoal) -> None:
        """A goal was sent.

        Args:
            driver: Driver of the robot whose goal it is.
            order: The goal, with the number of the try.
        """

    def on_settled(self, driver: RobotDriver, outcome: StopOutcome) -> None:
        """A stop is settled.

        Args:
            driver: Driver of the robot whose stop it is.
            outcome: The stop, reached or missed for good.
        """

    def on_over(self, driver: RobotDriver) -> bool:
        """The mission is over; return whether the robot is to be released from lockstep.

        Args:
            driver: Driver of the robot whose mission it is.
        """

    def on_status(self, driver: RobotDriver, status: RobotStatus) -> None:
        """A status message of the robot arrived.

        Args:
            driver: Driver of the robot that sent the status.
        """


class RobotDriver:
    """One robot on its mission.

    The next goal starts a pause after the tick in which the last one ended. That tick is in the
    status that the navigator publishes with the end, so the driver waits for both: the result
    and that status. The navigator in turn waits for the next goal (see Mission.msg), which makes
    a mission's outcome independent of how long all of this takes.

    Attributes:
        robot: The robot.
        itinerary: Its mission; None for a robot that is only watched.
        order: The goal sent last.
        tick: Tick of the latest status, of 0.1 s.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        itinerary: Itinerary | None,
        listener: Listener,
        *,
        announces: bool = True,
        door: StatusCheck | None = None,
    ) -> None:
        """Attach to a robot.

        Args:
            node: Node that all traffic goes through; spinning it is the caller's work.
            name: Namespace of the robot, like `Srobot3`.
            itinerary: Its mission; None to watch it only.
            listener: Told of the progress, from the callbacks of `node`.
            announces: Whether the robot is told that more goals follow, so that it waits for them.
            door: Check of the statuses of all robots of the caller; this robot's alone if None.
        """
        self.robot = RobotCommander(
            node, name, self._receive_status, with_feedback=False, door=door, watches_swarm=False
        )
        self.itinerary = itinerary
        self.order: NextGoal | None = None
        self.tick = 0
        self._listener = listener
        self._sent = 0
        self._settled = 0  # goals that the robot had ended when ours was sent
        self._ended: Task | None = None  # our goal, ended, its status not here yet
        self._mission = None
        if itinerary is not None and announces:
            self._mission = node.create_publisher(MissionMsg, f"/{name}/mission", LATCHED)

    @property
    def name(self) -> str:
        """Namespace of the robot."""
        return self.robot.name

    @property
    def is_over(self) -> bool:
        """Whether its mission is over."""
        return self.itinerary is None or self.itinerary.is_over

    @property
    def awaits_status(self) -> bool:
        """Whether a goal has ended, but the status with its time has not arrived yet."""
        return self._ended is not None

    def start(self, tick: int = 0) -> None:
        """Send the first goal, unless the mission has begun or there is none.

        Args:
            tick: Current tick, for a mission that goes on after a break; 0 for a new one.
        """
        if self.itinerary is not None and self.itinerary.state is ItineraryState.READY:
            self._announce(is_active=True)
            self._follow(self.itinerary.start(tick))

    def find(self) -> int:
        """The robot that was lost is there again: return how many goals it gets back."""
        if self.itinerary is None or self.itinerary.state is not ItineraryState.LOST:
            return 0
        count, order = self.itinerary.on_found(self.tick)
        self._announce(is_active=True)
        self._settled = self._settled_now
        self._follow(order)
        return count

    def lose(self) -> None:
        """The robot is gone: its remaining goals count as failed, unless it is found again."""
        if self.itinerary is None:
            return
        self._ended = None
        self.robot.forgetTask()
        outcomes = self.itinerary.on_lost(self.tick)
        for outcome in outcomes:
            self._listener.on_settled(self, outcome)
        if outcomes and self._listener.on_over(self):
            self.release()  # should it come back

    def release(self) -> None:
        """Tell the robot that no more goals follow."""
        self._announce(is_active=False)

    def abandon(self) -> None:
        """Give the mission up: cancel the goal and release the robot."""
        if not self.is_over:
            self.robot.cancelTask()
            self.release()
            self.itinerary = None  # else the cancelled goal counts as failed, and is sent again

    def settle_late(self) -> None:
        """Go on without the status that should have come with the end."""
        if self.awaits_status:
            self._close()

    def _announce(self, *, is_active: bool) -> None:
        if self._mission is not None:
            self._mission.publish(
                MissionMsg(stamp=time_msg(self.tick), active=is_active, goals_sent=self._sent)
            )

    def _follow(self, order: NextGoal | None) -> None:
        if order is None:
            if self._listener.on_over(self):
                self.release()
            return
        self.order = order
        self._sent += 1
        self._listener.on_sent(self, order)
        goal = NavigateToPose.Goal(
            pose=pose_stamped(order.stop.pose_map, self.tick),
            behavior_tree=start_text(order.start_tick),
        )
        self.robot.send("navigate_to_pose", NavigateToPose, goal, self._receive_end)

    @property
    def _settled_now(self) -> int:
        """Number of goals that the robot has ended since its navigator was started."""
        return 0 if self.robot.status is None else _settled_goals(self.robot.status)

    def _receive_status(self, status: RobotStatus) -> None:
        self.tick = tick_of(status.stamp)
        self._settled = min(self._settled, _settled_goals(status))  # a new navigator begins at 0
        self._listener.on_status(self, status)
        if self._ended is not None:
            self._settle(status)
        elif self.itinerary is not None and self.itinerary.state is ItineraryState.GIVING_WAY:
            if not has_goal(status):
                self._settled = _settled_goals(status)
                self._follow(self.itinerary.on_free_again(self.tick))
        elif self.robot.isTaskComplete():
            self._settled = _settled_goals(status)

    def _receive_end(self, task: Task) -> None:
        if self.itinerary is None or self.itinerary.is_over:
            return
        self._ended = task
        if task.is_forgotten:
            self._ended = None
            self._settled = self._settled_now
            self._follow(self.itinerary.on_forgotten(self.tick))
        elif task.result is None:  # refused: no status will tell of it
            self._close()
        elif self.robot.status is not None:
            self._settle(self.robot.status)

    def _settle(self, status: RobotStatus) -> None:
        """Decide about our ended goal, if this status is from after its end."""
        if self._ended is None or self.itinerary is None:
            return
        was_preempted = "preempted" in getattr(self._ended.result, "error_msg", "")
        missed = self._ended.outcome is not TaskResult.SUCCEEDED
        if missed and (was_preempted or self._is_elsewhere(status)):
            self._ended = None
            self.itinerary.on_taken_over()
        elif _settled_goals(status) > self._settled:
            self._close()

    def _is_elsewhere(self, status: RobotStatus) -> bool:
        """Whether the robot is on its way to a goal that is not ours."""
        if self.order is None or not has_goal(status):
            return False
        goal_map = self.order.stop.pose_map
        return math.hypot(status.goal.x - goal_map.x, status.goal.y - goal_map.y) > SAME_GOAL

    def _close(self) -> None:
        task, self._ended = self._ended, None
        if task is None or self.itinerary is None or self.itinerary.is_over:
            return
        if self.robot.status is not None:
            self._settled = _settled_goals(self.robot.status)
        known = len(self.itinerary.outcomes)
        reached = task.outcome is TaskResult.SUCCEEDED
        is_final = is_for_good(task.result)
        order = self.itinerary.on_end(reached, self.tick, task.reason, is_final=is_final)
        for outcome in self.itinerary.outcomes[known:]:
            self._listener.on_settled(self, outcome)
        self._follow(order)


def sim_seconds(tick: int) -> float:
    """Return the simulated time of a tick [s].

    Args:
        tick: Number of control periods of 0.1 s since the start.
    """
    return round(tick * CONTROL_PERIOD, 3)


def has_goal(status: RobotStatus) -> bool:
    """Whether the robot has any goal.

    Args:
        status: Status of the robot; the goal in it is NaN where there is none.
    """
    return not math.isnan(status.goal.x)


def is_for_good(result: Any) -> bool:
    """Return whether another try of a goal would end alike, since the map alone decided it.

    Args:
        result: Result of a NavigateToPose; None if the goal was refused.
    """
    return is_final(getattr(result, "error_code", 0), getattr(result, "error_msg", ""))


def is_final(code: int, reason: str) -> bool:
    """Return whether another try of a goal would end alike.

    Args:
        code: Nav2's error code.
        reason: Message that came with the code.
    """
    return code in OFF_THE_MAP or ON_THIS_MAP in reason


def _settled_goals(status: RobotStatus) -> int:
    return int(status.goals_reached + status.goals_failed)

"""Plug-ins: some that work, and some that fail in every way."""

import heapq
import math
import time

import numpy as np

from swarm_nav.interfaces import (
    CostGrid,
    DriveLimits,
    FloatArray,
    Grid,
    Odometry,
    PathAhead,
    Pose,
    RankedGoal,
    RobotSpec,
    Scan,
    Twist,
)

JUMP = 60  # ticks after which `Jumping` does
LATE = 0.2  # [s] that a call of `Late` takes


class Pursuit:
    """Turns towards a point ahead, and drives on."""

    def __init__(self, spec: RobotSpec) -> None:
        self.gain = 2.0

    def follow(self, path: PathAhead, pose_map: Pose, twist: Twist, limits: DriveLimits) -> Twist:
        x, y = path.points_map[min(4, len(path.points_map) - 1)]
        way = math.atan2(y - pose_map.y, x - pose_map.x)
        turn = math.remainder(way - pose_map.yaw, math.tau)
        speed = 0.0 if abs(turn) > 0.5 else limits.max_vel_x
        return Twist(speed, 0.0, self.gain * turn)


class Dijkstra:
    """Searches eight neighbours."""

    def __init__(self, spec: RobotSpec) -> None:
        self.steps = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]

    def plan(
        self, grid: CostGrid, start_map: tuple[float, float], goal_map: tuple[float, float]
    ) -> FloatArray:
        origin = np.array((grid.origin_x, grid.origin_y))
        (j, i), (goal_j, goal_i) = (
            np.floor((np.array(point) - origin) / grid.step).astype(int).tolist()
            for point in (start_map, goal_map)
        )
        start, goal = (i, j), (goal_i, goal_j)
        height, width = grid.costs.shape
        best, came, queue = {start: 0.0}, {start: start}, [(0.0, start)]
        while (queue and goal not in came) or (queue and queue[0][0] < best[goal]):
            cost, (i, j) = heapq.heappop(queue)
            for di, dj in self.steps:
                to = i + di, j + dj
                if 0 <= to[0] < height and 0 <= to[1] < width:
                    total = cost + math.hypot(di, dj) * float(grid.costs[to])
                    if total < best.get(to, math.inf):
                        best[to], came[to] = total, (i, j)
                        heapq.heappush(queue, (total, to))
        if goal not in came:
            return np.zeros((0, 2))
        cells = [goal]
        while cells[-1] != start:
            cells.append(came[cells[-1]])
        return (np.array(cells[::-1])[:, ::-1] + 0.5) * grid.step + origin


class HighestId:
    """Lets the robot of the largest number go first."""

    def __init__(self, spec: RobotSpec) -> None:
        pass

    def seniority(self, task: RankedGoal) -> int:
        return task.robot_id


class DeadReckoning:
    """Trusts the odometry."""

    def __init__(self, spec: RobotSpec, grid: Grid, pose_map: Pose) -> None:
        self.pose_map, self.last = pose_map, None

    def on_scan(self, scan: Scan) -> None:
        pass

    def on_odom(self, odom: Odometry) -> tuple[Pose, float]:
        last = self.last or odom.pose_odom
        self.pose_map = self.pose_map.compose(last.inverse().compose(odom.pose_odom))
        self.last = odom.pose_odom
        return self.pose_map, 0.0


class Jumping(DeadReckoning):
    """Finds itself half a metre further left after a while."""

    calls = 0

    def on_odom(self, odom: Odometry) -> tuple[Pose, float]:
        self.calls += 1
        pose, _ = super().on_odom(odom)
        return Pose(pose.x, pose.y + 0.5 * (self.calls > JUMP), pose.yaw), 0.0


class Failing:
    """A controller, planner, localiser, priority and brain that raises."""

    def __init__(self, *arguments: object) -> None:
        pass

    def act(self, *arguments: object) -> object:
        raise ValueError("out of order")

    def follow(self, *arguments: object) -> object:
        return self.act()

    plan = on_odom = seniority = tick = follow

    def on_scan(self, scan: Scan) -> None:
        pass

    on_reception = set_goal = on_scan


class Nan(Failing):
    """Returns nothing that makes sense."""

    def follow(self, *arguments: object) -> object:
        return Twist(math.nan, 0.0, 0.0)

    def plan(self, *arguments: object) -> object:
        return np.full((3, 2), np.nan)

    def on_odom(self, *arguments: object) -> object:
        return Pose(math.nan, 0.0, 0.0), 0.0

    def act(self, *arguments: object) -> object:
        return math.nan

    seniority = tick = act


class Late(Failing):
    """Answers late."""

    def act(self, *arguments: object) -> object:
        time.sleep(LATE)
        return None


class Unmade(Failing):
    """Cannot be made."""

    def __init__(self, *arguments: object) -> None:
        raise OSError("no such device")

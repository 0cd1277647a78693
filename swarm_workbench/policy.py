"""A trained policy as the brain of a robot: `brain.plugin: policy.onnx`, with the extra `learn`.

The model's inputs have the names and shapes of an observation of `swarm_workbench.gym`, each with a
first dimension of 1: `scan`, `goal`, `twist`, `neighbours`, or some of them. Its first output is
the action.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import onnxruntime

from swarm_common.model.beacon import Reception
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.model.sites import Sites
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalEnded, Outcome, Output
from swarm_workbench.observation import NEIGHBOUR, REACHED, observe, twist_of
from swarm_workbench.steered import SteeredNavigator

OF_NAVIGATOR = {
    "load_map", "local_costmap", "global_costmap", "map_from_odom", "on_initial_pose", "particles",
    "plan_map", "pose_map", "variances",
}  # fmt: skip


class Policy:
    """A model in ONNX that turns observations of one robot into twists."""

    def __init__(self, path: str, spec: RobotSpec) -> None:
        """Read it.

        Raises:
            ConfigError: If its inputs are not parts of an observation.
        """
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self._model = onnxruntime.InferenceSession(path, options, ["CPUExecutionProvider"])
        self._spec = spec
        self.inputs = {each.name: list(each.shape) for each in self._model.get_inputs()}
        neighbours = self.inputs.get("neighbours", [1, 1, NEIGHBOUR])[1]
        self.neighbours = neighbours if isinstance(neighbours, int) else 4
        shapes = {
            "scan": [1, spec.lidar.rays],
            "goal": [1, 2],
            "twist": [1, 3],
            "neighbours": [1, self.neighbours, NEIGHBOUR],
        }
        for name, shape in self.inputs.items():
            wanted = shapes.get(name, [])
            if len(shape) != len(wanted) or any(
                isinstance(found, int) and found != size
                for found, size in zip(shape, wanted, strict=True)
            ):
                raise ConfigError(
                    f"{path} has the input {name} {shape}; expected some of {shapes}, as"
                    f" observations of {spec.model} are"
                )

    def twist(
        self, ranges: Any, goal_map: tuple[float, float], poses: FloatArray, twists: FloatArray
    ) -> Twist:
        """Return the twist of a tick; arguments as of `observe`, the robot's own row first."""
        seen = observe(
            ranges[None], self._spec.lidar.range_max, np.array([goal_map]), poses, twists,
            self.neighbours,
        )  # fmt: skip
        action = self._model.run(None, {name: seen[name] for name in self.inputs})[0]
        return twist_of(np.ravel(action), self._spec)


class PolicyBrain:
    """A robot that a policy steers, inside space that it has reserved; see `Brain`.

    A goal is reached within `REACHED` of it, at whatever heading.
    """

    def __init__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
    ) -> None:
        """Stand at a pose without a goal; `brain.plugin` is the path of the model."""
        self._policy = Policy(config.brain.plugin, spec)
        self._steered = SteeredNavigator(config, spec, grid, sites, robot_id, initial_pose_map)
        self._navigator = self._steered.navigator
        self._ranges = np.full(spec.lidar.rays, np.inf, np.float32)
        self._twist = Twist()
        self._others = Reception(np.zeros((0, 0), np.uint32), np.zeros(0, np.int64))
        self._goal: Goal | None = None

    def __getattr__(self, name: str) -> Any:
        if name in OF_NAVIGATOR:
            return getattr(self._navigator.services, name)
        raise AttributeError(name)

    def on_odom(self, odom: Odometry) -> None:
        """Receive the odometry of this tick."""
        self._twist = odom.twist
        self._navigator.on_odom(odom)

    def on_scan(self, scan: Scan) -> None:
        """Receive a scan."""
        self._ranges = scan.ranges
        self._navigator.on_scan(scan)

    def on_reception(self, reception: Reception) -> None:
        """Receive the beacons heard in this tick."""
        self._others = reception
        self._navigator.on_reception(reception)

    def set_goal(self, goal: Goal) -> None:
        """Receive a goal; only the first of its poses is used."""
        self._goal = goal

    def cancel_goal(self) -> None:
        """Stand."""
        self._goal = None

    def tick(self, tick: int) -> Output:
        """Decide."""
        goal = self._goal
        events: tuple[GoalEnded, ...] = ()
        self._steered.wish = Twist()
        if goal is not None and goal.start_tick <= tick:
            pose, target = self._navigator.pose_map, goal.poses_map[0]
            if pose.distance(target) < REACHED:
                events, self._goal = (GoalEnded(goal.goal_id, Outcome.SUCCEEDED, tick),), None
            else:
                self._steered.wish = self._decide(pose, target)
        output = self._navigator.tick(tick)
        return Output(output.twist, output.beacon, events)

    def _decide(self, pose: Pose, target: Pose) -> Twist:
        beacons = self._others.beacons if len(self._others.rows) else None
        poses, twists = [(pose.x, pose.y, pose.yaw)], [self._twist_row()]
        if beacons is not None:
            poses += beacons["pose"].tolist()
            twists += [(vx, wz, 0.0) for vx, wz in beacons["twist"].tolist()]
        return self._policy.twist(
            self._ranges, (target.x, target.y), np.array(poses), np.array(twists)
        )

    def _twist_row(self) -> tuple[float, float, float]:
        return self._twist.vx, self._twist.wz, self._twist.vy

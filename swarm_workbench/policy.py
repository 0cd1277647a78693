"""A trained policy as the brain of a robot: `brain.plugin: policy.onnx`, with the extra `learn`.

The model's inputs have the names and shapes of an observation of `swarm_workbench.gym`, each with a
first dimension of 1, or some of them. Its first output is the action.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import onnxruntime
from numpy.typing import NDArray

from swarm_common.files.convert import convert
from swarm_common.model.beacon import Reception
from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import FloatArray, Odometry, Pose, RobotSpec, Scan, Twist
from swarm_common.model.sites import Sites
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import Goal, GoalEnded, Outcome, Output
from swarm_workbench.observation import (
    FLAT,
    NEIGHBOUR,
    PARTS,
    REACHED,
    Observer,
    PolicyConfig,
    flat,
    twist_of,
)
from swarm_workbench.steered import SteeredNavigator
from swarm_workbench.ways import ShortestWays

CONFIG = "swarm_workbench"  # key of a model's metadata

OF_NAVIGATOR = {
    "load_map", "local_costmap", "global_costmap", "map_from_odom", "on_initial_pose", "particles",
    "plan_map", "pose_map", "variances",
}  # fmt: skip


def _session(path: str) -> Any:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    try:
        return onnxruntime.InferenceSession(path, options, ["CPUExecutionProvider"])
    except Exception as error:  # of a dozen kinds
        raise ConfigError(f"{path} is no model in ONNX that can be read: {error}") from None


def _inputs(model: Any) -> dict[str, list[Any]]:
    return {each.name: list(each.shape) for each in model.get_inputs()}


def _written_in(model: Any, path: str) -> PolicyConfig:
    """Return what `describe_policy` wrote into a model, or what the names of its inputs say."""
    written = model.get_modelmeta().custom_metadata_map.get(CONFIG)
    if written is not None:
        try:
            found = msgspec.json.decode(written)
        except msgspec.DecodeError:
            found = written
        return convert(found, PolicyConfig, f"{path}: {CONFIG}")
    inputs = _inputs(model)
    neighbours = inputs.get("neighbours", [1, 4, NEIGHBOUR])[1]
    count = neighbours if isinstance(neighbours, int) and neighbours > 0 else 4
    parts = tuple(part for part in PARTS if part in inputs)
    return PolicyConfig(parts=parts or ("goal",), neighbours=count)


class Policy:
    """A model in ONNX that turns observations of one robot into twists.

    Attributes:
        config: What it sees, and how its actions are meant.
        inputs: Shapes of its inputs by name.
    """

    def __init__(self, path: str, spec: RobotSpec) -> None:
        """Read it.

        Raises:
            ConfigError: If its inputs are not parts of an observation.
        """
        self._model = _session(path)
        self._spec = spec
        self.inputs = _inputs(self._model)
        self.config = _written_in(self._model, path)
        self._observer = Observer(self.config, spec, 1)
        shapes = {name: [1, *bounds.shape] for name, bounds in self._observer.bounds.items()}
        if self.config.observation == "flat":
            shapes = {FLAT: [1, sum(math.prod(shape) for shape in shapes.values())]}
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

    def restart(self, ranges: Any) -> None:
        """Begin a way to a goal, with the ranges (rays,) [m] of the latest scan."""
        self._observer.restart(ranges[None], np.ones(1, np.bool_))

    def twist(
        self,
        ranges: Any,
        goal_map: tuple[float, float],
        ahead_map: tuple[float, float],
        poses: FloatArray,
        twists: FloatArray,
        numbers: NDArray[np.int64],
    ) -> Twist:
        """Return the twist of a step.

        Args:
            ranges: (rays,) [m] of the latest scan.
            goal_map: x, y [m].
            ahead_map: x, y [m] where the way leads.
            poses: (n, 3) x, y, yaw in map, its own first.
            twists: (n, 3) vx, wz, vy.
            numbers: (n,) of the robots.
        """
        self._observer.add(ranges[None])
        goals, ahead = np.array([goal_map]), np.array([ahead_map])
        seen = self._observer.observe(goals, ahead, poses, twists, numbers)
        if self.config.observation == "flat":
            seen = {FLAT: flat(seen)}
        action = self._model.run(None, {name: seen[name] for name in self.inputs})[0]
        return twist_of(np.ravel(action)[:3], self._spec, self.config.normalise)


def describe_policy(path: str | Path, options: PolicyConfig) -> None:
    """Write into a model in ONNX what it sees, so that robots show it the same.

    Args:
        path: File of the model, which is overwritten. Its inputs are called as the parts of an
            observation, or `observation` where that is flat; its first output is the action.
        options: What it was trained with: `options` of an environment.

    Raises:
        ConfigError: If the file cannot be read or written.
    """
    import onnx
    from google.protobuf.message import DecodeError  # type: ignore[import-untyped]

    fields = PolicyConfig.__struct_fields__
    written = msgspec.json.encode({name: getattr(options, name) for name in fields}).decode()
    try:
        model = onnx.load(str(path))
        onnx.helper.set_model_props(model, {CONFIG: written})
        onnx.save(model, str(path))
    except (OSError, DecodeError) as error:
        raise ConfigError(f"{path} is no model in ONNX that can be written: {error}") from None


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
        self._policy = policy = Policy(config.brain.plugin, spec)
        self._ways: ShortestWays | None = None
        if "way" in policy.config.parts:
            self._ways = ShortestWays(grid, spec.circumscribed_radius, 1)
        self._wish, self._held = Twist(), 0  # the last action, and for how many ticks still
        self._steered = SteeredNavigator(config, spec, grid, sites, robot_id, initial_pose_map)
        self._navigator = self._steered.navigator
        self._ranges = np.full(spec.lidar.rays, np.inf, np.float32)
        self._twist = Twist()
        self._others = Reception(np.zeros((0, 0), np.uint32), np.zeros(0, np.int64))
        self._goal: Goal | None = None
        self._number = robot_id

    @staticmethod
    def check_config(config: NavConfig) -> None:
        """Refuse a model that sees scans where there are no LiDARs.

        Raises:
            ConfigError: If it does, or is no model of a policy.
        """
        path = config.brain.plugin
        if config.costmap.scan_timeout == 0.0 and "scan" in _written_in(_session(path), path).parts:
            raise ConfigError(
                f"{path} sees scans, and this run has no LiDARs: switch them on (lidar=True of"
                " run_scenario, --lidar of swarm-bench, with_lidar in a scenario,"
                " costmap.scan_timeout above 0)"
            )

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
        self._goal, self._held = goal, -1

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
        if self._held > 0:
            self._held -= 1
            return self._wish
        goal = ahead = (target.x, target.y)
        if self._held < 0:  # a new goal
            self._policy.restart(self._ranges)
            if self._ways is not None:
                self._ways.set_goal(0, np.array(goal))
        self._held = self._policy.config.ticks - 1
        beacons = self._others.beacons if len(self._others.rows) else None
        poses, twists = [(pose.x, pose.y, pose.yaw)], [self._twist_row()]
        numbers = [self._number]
        if beacons is not None:
            poses += beacons["pose"].tolist()
            twists += [(vx, wz, 0.0) for vx, wz in beacons["twist"].tolist()]
            numbers += beacons["id"].tolist()
        if self._ways is not None:
            self._ways.follow(np.array(poses[:1]))
            x, y = self._ways.ahead[0].tolist()
            ahead = x, y
        self._wish = self._policy.twist(
            self._ranges, goal, ahead, np.array(poses), np.array(twists), np.array(numbers)
        )
        return self._wish

    def _twist_row(self) -> tuple[float, float, float]:
        return self._twist.vx, self._twist.wz, self._twist.vy

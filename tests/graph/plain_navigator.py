"""A user's script with nothing but rclpy and nav2_msgs, written the way BasicNavigator is.

python plain_navigator.py NAMESPACE X Y YAW drives one robot whose start pose is given.
"""

import math
import sys
import time

import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import (
    BackUp,
    ComputePathThroughPoses,
    ComputePathToPose,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
)
from nav2_msgs.srv import ClearEntireCostmap, GetCostmap
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile

ACTIONS = {
    "navigate_to_pose": NavigateToPose,
    "navigate_through_poses": NavigateThroughPoses,
    "follow_waypoints": FollowWaypoints,
    "follow_path": FollowPath,
    "compute_path_to_pose": ComputePathToPose,
    "compute_path_through_poses": ComputePathThroughPoses,
    "spin": Spin,
    "backup": BackUp,
}


class PlainNavigator(Node):
    def __init__(self, namespace):
        super().__init__("basic_navigator", namespace=namespace)
        latched = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        self.pose = None
        self.feedback = None
        self.actions = {name: ActionClient(self, kind, name) for name, kind in ACTIONS.items()}
        self.create_subscription(PoseWithCovarianceStamped, "amcl_pose", self.on_pose, latched)
        self.initial_pose = self.create_publisher(PoseWithCovarianceStamped, "initialpose", 10)

    def on_pose(self, message):
        self.pose = message.pose.pose

    def on_feedback(self, message):
        self.feedback = message.feedback

    def call(self, kind, name, request):
        client = self.create_client(kind, name)
        while not client.wait_for_service(timeout_sec=1.0):
            self.get_logger().info(f"{name} not available, waiting...")
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def wait_for_node(self, name):
        while True:
            state = self.call(GetState, f"{name}/get_state", GetState.Request())
            if state.current_state.label == "active":
                return
            time.sleep(0.2)

    def wait_until_active(self, pose):
        self.wait_for_node("amcl")
        self.pose = None
        while self.pose is None:
            message = PoseWithCovarianceStamped()
            message.header.frame_id = "map"
            message.pose.pose = pose.pose
            self.initial_pose.publish(message)
            rclpy.spin_once(self, timeout_sec=1.0)
        self.wait_for_node("bt_navigator")

    def send(self, name, goal):
        client = self.actions[name]
        while not client.wait_for_server(timeout_sec=1.0):
            self.get_logger().info(f"{name} not available, waiting...")
        self.feedback = None
        future = client.send_goal_async(goal, self.on_feedback)
        rclpy.spin_until_future_complete(self, future)
        handle = future.result()
        assert handle.accepted, name
        return handle

    def result(self, handle):
        future = handle.get_result_async()
        rclpy.spin_until_future_complete(self, future, timeout_sec=60.0)
        assert future.result() is not None, "no result after 60 s"
        return future.result()

    def succeed(self, name, goal):
        answer = self.result(self.send(name, goal))
        assert answer.status == GoalStatus.STATUS_SUCCEEDED, (name, answer)
        return answer.result


def pose_at(x, y, yaw=0.0):
    pose = PoseStamped()
    pose.header.frame_id = "map"
    pose.pose.position.x, pose.pose.position.y = x, y
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose


def drive(navigator, x, y):
    """Every kind of task once, all near (x, y)."""
    navigator.succeed("navigate_to_pose", NavigateToPose.Goal(pose=pose_at(x, y + 1.5, 1.57)))
    assert navigator.feedback.distance_remaining < 2.0
    assert math.dist((x, y + 1.5), (navigator.pose.position.x, navigator.pose.position.y)) < 2.5

    handle = navigator.send("navigate_to_pose", NavigateToPose.Goal(pose=pose_at(x, y + 6.0)))
    while navigator.feedback is None:
        rclpy.spin_once(navigator, timeout_sec=1.0)
    rclpy.spin_until_future_complete(navigator, handle.cancel_goal_async())
    assert navigator.result(handle).status == GoalStatus.STATUS_CANCELED

    first = navigator.send("navigate_to_pose", NavigateToPose.Goal(pose=pose_at(x, y + 6.0)))
    poses = [pose_at(x, y + 2.0), pose_at(x, y + 3.0, 1.57)]
    navigator.succeed("follow_waypoints", FollowWaypoints.Goal(poses=poses))
    answer = navigator.result(first)  # the later goal took its place
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert "preempted" in answer.result.error_msg
    assert navigator.feedback.current_waypoint == 1

    poses = [pose_at(x, y + 2.0), pose_at(x, y + 1.0, -1.57)]
    navigator.succeed("navigate_through_poses", NavigateThroughPoses.Goal(poses=poses))
    assert navigator.feedback.number_of_poses_remaining == 1


def plan_and_behave(navigator, x, y):
    goal = ComputePathToPose.Goal(goal=pose_at(x, y + 2.0), start=pose_at(x, y), use_start=True)
    path = navigator.succeed("compute_path_to_pose", goal).path
    assert path.header.frame_id == "map"
    assert abs(path.poses[-1].pose.position.y - (y + 2.0)) < 0.3
    navigator.succeed("follow_path", FollowPath.Goal(path=path))
    goals = [pose_at(x, y + 1.0), pose_at(x, y + 2.0)]
    navigator.succeed("compute_path_through_poses", ComputePathThroughPoses.Goal(goals=goals))
    for far in (500.0, 1e308):
        unreachable = ComputePathToPose.Goal(goal=pose_at(far, 0.0))
        answer = navigator.result(navigator.send("compute_path_to_pose", unreachable))
        assert answer.status == GoalStatus.STATUS_ABORTED
        assert answer.result.error_code == ComputePathToPose.Result.GOAL_OUTSIDE_MAP
        unreachable = ComputePathToPose.Goal(
            goal=pose_at(x, y), start=pose_at(far, 0.0), use_start=True
        )
        answer = navigator.result(navigator.send("compute_path_to_pose", unreachable))
        assert answer.result.error_code == ComputePathToPose.Result.START_OUTSIDE_MAP
    elsewhere = ComputePathToPose.Goal(goal=pose_at(x, y + 1.0))
    elsewhere.goal.header.frame_id = "nowhere"
    answer = navigator.result(navigator.send("compute_path_to_pose", elsewhere))
    assert answer.result.error_code == ComputePathToPose.Result.TF_ERROR
    nothing = ComputePathThroughPoses.Goal()
    answer = navigator.result(navigator.send("compute_path_through_poses", nothing))
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert answer.result.error_code == ComputePathThroughPoses.Result.NO_VIAPOINTS_GIVEN

    spin = Spin.Goal(target_yaw=1.57)
    spin.time_allowance.sec = 20
    navigator.succeed("spin", spin)
    backup = BackUp.Goal(speed=0.1)
    backup.target.x = 0.3
    backup.time_allowance.sec = 20
    navigator.succeed("backup", backup)

    for name in ("local_costmap", "global_costmap"):
        request = ClearEntireCostmap.Request()
        navigator.call(ClearEntireCostmap, f"{name}/clear_entirely_{name}", request)
        costmap = navigator.call(GetCostmap, f"{name}/get_costmap", GetCostmap.Request()).map
        assert len(costmap.data) == costmap.metadata.size_x * costmap.metadata.size_y


def main():
    namespace, x, y, yaw = sys.argv[1], *(float(word) for word in sys.argv[2:5])
    rclpy.init()
    navigator = PlainNavigator(namespace)
    navigator.wait_until_active(pose_at(x, y, yaw))
    drive(navigator, x, y)
    plan_and_behave(navigator, x, y)
    navigator.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()

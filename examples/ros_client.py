"""A plain ROS 2 node drives a robot by Nav2's action; it knows nothing of this project."""

import os

import rclpy
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient

from swarm_workbench import Swarm

with Swarm(robots=1, drive="planar") as swarm:
    os.environ["ROS_DOMAIN_ID"] = str(swarm.domain)
    rclpy.init()
    node = rclpy.create_node("client")
    client = ActionClient(node, NavigateToPose, "/Srobot1/navigate_to_pose")
    client.wait_for_server()
    goal = NavigateToPose.Goal()
    goal.pose.header.frame_id = "map"
    start = swarm["Srobot1"].true_pose
    goal.pose.pose.position.x, goal.pose.pose.position.y = start.x - 0.5, start.y
    sent = client.send_goal_async(goal)
    rclpy.spin_until_future_complete(node, sent)
    result = sent.result().get_result_async()
    while not result.done():
        swarm.run(seconds=0.5)  # time stands still unless somebody waits
        rclpy.spin_once(node, timeout_sec=0.0)
    print("status", result.result().status, "at t =", round(swarm.time, 1))
    rclpy.shutdown()

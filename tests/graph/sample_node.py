"""A small node with one of everything (once it says so), for the tests of the `ros2` command."""

import sys
import time
from typing import Any

import rclpy
from nav2_msgs.action import Wait
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import SetParametersResult
from rclpy.action import ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from std_srvs.srv import SetBool

RATE = 20.0


def refuse_negative(parameters: list[Any]) -> SetParametersResult:
    """Refuse a speed below zero with a reason."""
    if any(p.name == "max_vel_x" and p.value < 0.0 for p in parameters):
        return SetParametersResult(successful=False, reason="max_vel_x must not be negative")
    return SetParametersResult(successful=True)


def wait(handle: Any) -> Wait.Result:
    """Answer a Wait goal with feedback; what is sent before clients are matched is lost."""
    for _ in range(10):
        handle.publish_feedback(Wait.Feedback())
        time.sleep(0.05)
    handle.succeed()
    return Wait.Result(error_msg="waited")


def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    """Repeat the request."""
    response.success = request.data
    response.message = "as you say"
    return response


def main() -> None:
    """Run until killed."""
    rclpy.init()
    node = rclpy.create_node("sample", namespace="/Srobot1")
    node.declare_parameter("max_vel_x", 0.26)
    node.add_on_set_parameters_callback(refuse_negative)
    odom = node.create_publisher(Odometry, "odom", 10)
    scan = node.create_publisher(LaserScan, "scan", qos_profile_sensor_data)
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_publisher(String, "description", kept).publish(String(data="a robot"))
    heard = node.create_publisher(String, "heard", 10)
    node.create_subscription(String, "say", heard.publish, 10)
    node.create_service(SetBool, "switch", answer)
    ActionServer(node, Wait, "wait", wait)

    def publish() -> None:
        message = Odometry()
        message.pose.pose.position.x = 1.5
        odom.publish(message)
        scan.publish(LaserScan(ranges=[0.5] * 360))

    node.create_timer(1.0 / RATE, publish)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    executor.spin()


if __name__ == "__main__":
    main()

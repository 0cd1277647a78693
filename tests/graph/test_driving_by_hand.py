"""A page drives a robot by hand: it takes it, steers it and gives it back to its navigator."""

import threading
import time

import rclpy
from geometry_msgs.msg import Twist
from nav2_msgs.action import AssistedTeleop
from rclpy.action import ActionServer
from rclpy.executors import MultiThreadedExecutor
from std_msgs.msg import Empty

from swarm_view.page.driving import Driving
from swarm_view.state.operator_link import OperatorLink
from tests.graph.conftest import reserved_domain


def test_a_robot_is_taken_steered_and_given_back():
    with reserved_domain() as domain:
        rclpy.init(domain_id=domain)
        robot = rclpy.create_node("navigator", namespace="Srobot1")
        robot.declare_parameter("max_vel_x", 0.2)
        robot.declare_parameter("max_vel_theta", 1.0)
        wishes: list[Twist] = []
        over = threading.Event()
        robot.create_subscription(Twist, "cmd_vel_teleop", wishes.append, 10)
        robot.create_subscription(Empty, "preempt_teleop", lambda _: over.set(), 10)

        def execute(goal):
            over.wait(30.0)
            goal.succeed()
            return AssistedTeleop.Result()

        server = ActionServer(robot, AssistedTeleop, "assisted_teleop", execute)
        executor = MultiThreadedExecutor(2)
        executor.add_node(robot)
        spinning = threading.Thread(target=executor.spin, daemon=True)
        spinning.start()
        page = rclpy.create_node("viewer")
        link = OperatorLink(page)
        driving, told, ended = Driving(link), [], []
        driving.set_share(1.0)
        driving.begin("Srobot1", told.append, lambda: ended.append(True))
        end = time.monotonic() + 30.0
        while not any(wish.linear.x > 0.0 for wish in wishes) and time.monotonic() < end:
            now = time.monotonic()
            driving.steer(1.0, 0.5, now)
            driving.update(now)
            link.turn(now)
            time.sleep(0.02)
        assert told == ["Srobot1 is yours."]
        assert (wishes[-1].linear.x, wishes[-1].angular.z) == (0.2, 0.5)
        driving.end()
        while len(told) < 2 and time.monotonic() < end:
            link.turn(time.monotonic())
            time.sleep(0.02)
        assert told[1] == "Srobot1 is on its own again."
        link.close()
        server.destroy()
        executor.shutdown()
        spinning.join(10.0)
        for node in (page, robot):
            node.destroy_node()
        rclpy.shutdown()

"""Navigators of a large swarm: servers that few clients use come when they are asked for."""

from geometry_msgs.msg import Point
from nav2_msgs.action import BackUp, DriveOnHeading, Spin
from nav2_msgs.msg import Costmap
from rclpy.action import ActionClient

from swarm_common.middleware.ros_io import LATCHED
from tests.graph.conftest import START_LIMIT

OPTIONS = dict(on_demand=True)


def services_of(swarm, name):
    return {
        service.removeprefix(f"/{name}/")
        for service, _ in swarm.node.get_service_names_and_types()
        if service.startswith(f"/{name}/")
    }


def test_only_what_every_robot_needs_is_there_at_first(swarm):
    expected = {
        f"navigate_to_pose/_action/{name}" for name in ("send_goal", "get_result", "cancel_goal")
    }
    swarm.spin_until(lambda: services_of(swarm, "Srobot1") >= expected)
    swarm.spin(1.0)  # for what should not be there
    assert services_of(swarm, "Srobot1") == expected


def test_an_action_server_comes_for_its_client(swarm):
    service = "/Srobot2/spin/_action/send_goal"
    client = swarm.node.create_client(Spin.Impl.SendGoalService, service)
    try:
        assert client.wait_for_service(20.0)
    finally:
        swarm.node.destroy_client(client)
    assert "follow_path/_action/send_goal" not in services_of(swarm, "Srobot2")


def test_driving_on_can_be_asked_for_once_backup_is_there(swarm):
    """As nav2_simple_commander's driveOnHeading does; its goal was lost, and it waited for ever."""
    backup = ActionClient(swarm.node, BackUp, "/Srobot1/backup")
    drive = ActionClient(swarm.node, DriveOnHeading, "/Srobot1/drive_on_heading")
    assert backup.wait_for_server(20.0)
    goal = DriveOnHeading.Goal(target=Point(x=0.1), speed=0.1)
    assert swarm.result_of(drive.send_goal_async(goal)).accepted
    backup.destroy()
    drive.destroy()


def test_raw_costmaps_come_for_their_listener(swarm):
    def topics():
        return {name for name, _ in swarm.node.get_topic_names_and_types()}

    heard = []
    topic = "/Srobot2/local_costmap/costmap_raw"
    assert topic not in topics()
    subscription = swarm.node.create_subscription(Costmap, topic, heard.append, LATCHED)
    swarm.spin_until(lambda: heard, START_LIMIT)
    assert "/Srobot1/local_costmap/costmap_raw" not in topics()
    swarm.node.destroy_subscription(subscription)

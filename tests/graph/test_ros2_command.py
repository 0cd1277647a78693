"""The `ros2` command against a node with one of everything."""

import io
import math
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from swarm_ros2 import command_line
from swarm_ros2.graph import open_node

SAMPLE = Path(__file__).with_name("sample_node.py")
NODE = "/Srobot1/sample"


@pytest.fixture(scope="module", autouse=True)
def sample():
    process = subprocess.Popen([sys.executable, str(SAMPLE)], stdout=subprocess.PIPE)
    try:
        assert process.stdout.readline() == b"ready\n"
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def ros2(capfd):
    return Ros2(capfd)


class Ros2:
    """Runs a command line; keeps what it printed."""

    def __init__(self, capture):
        self._capture = capture
        self.err = ""

    def __call__(self, *arguments, code=0):
        self._capture.readouterr()
        assert command_line.run(arguments) == code
        out, self.err = self._capture.readouterr()
        return out


def test_topic_list_shows_names_and_types_within_two_seconds(ros2):
    took = math.inf
    for _ in range(3):  # the machine may be busy with something else
        start = time.monotonic()
        lines = ros2("topic", "list", "-t").splitlines()
        took = min(took, time.monotonic() - start)
        if took < 2.0:
            break
    assert took < 2.0
    assert "/Srobot1/odom [nav_msgs/msg/Odometry]" in lines
    assert "/Srobot1/scan [sensor_msgs/msg/LaserScan]" in lines
    assert lines == sorted(lines)
    assert not any("_action" in line for line in lines)


def test_a_process_that_had_no_time_to_announce_itself_is_waited_for(ros2, sample):
    """On a busy machine the topics of a robot were missing."""
    sample.send_signal(signal.SIGSTOP)
    timer = threading.Timer(2.5, sample.send_signal, (signal.SIGCONT,))
    timer.start()
    try:
        with open_node():  # that announces itself
            assert ros2("node", "list") == f"{NODE}\n"
    finally:
        timer.join()


def test_topic_info_type_find_and_options(ros2):
    expected = "Type: std_msgs/msg/String\nPublisher count: 0\nSubscription count: 1\n"
    assert ros2("topic", "info", "/Srobot1/say") == expected
    text = ros2("topic", "info", "-v", "/Srobot1/scan")
    assert "Node name: sample\nNode namespace: /Srobot1\n" in text
    assert "Topic type hash: RIHS01_" in text
    assert "  Reliability: BEST_EFFORT\n" in text
    assert ros2("topic", "type", "/Srobot1/odom") == "nav_msgs/msg/Odometry\n"
    assert ros2("topic", "find", "nav_msgs/msg/Odometry") == "/Srobot1/odom\n"
    assert ros2("topic", "find", "-c", "nav_msgs/msg/Odometry") == "1\n"
    assert ros2("service", "find", "-c", "std_srvs/srv/SetBool") == "1\n"
    common = ("--no-daemon", "--spin-time", "2", "--use-sim-time")
    assert "/Srobot1/odom" in ros2("topic", "list", *common).splitlines()
    assert ros2("node", "list", "-s", "--no-daemon") == f"{NODE}\n"
    assert "max_vel_x" in ros2("param", "list", NODE, "--include-hidden-nodes", *common)
    ros2("topic", "info", "/nowhere", code=1)
    assert ros2.err == "Unknown topic '/nowhere'\n"


def test_echo_of_messages_fields_and_arrays(ros2):
    text = ros2("topic", "echo", "--once", "/Srobot1/odom")
    assert text.startswith("header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\n")
    assert text.endswith("---\n")
    assert text.count("---\n") == 1
    assert "      x: 1.5\n" in text
    text = ros2("topic", "echo", "--once", "/Srobot1/odom", "--field", "pose.pose.position")
    assert text == "x: 1.5\ny: 0.0\nz: 0.0\n---\n"
    assert ros2("topic", "echo", "--once", "/Srobot1/odom", "--field", "pose.pose.position.x") == (
        "1.5\n---\n"
    )
    text = ros2("topic", "echo", "--once", "/Srobot1/scan", "--no-arr")
    assert "ranges: '<sequence type: float, length: 360>'\n" in text
    text = ros2("topic", "echo", "--once", "/Srobot1/scan", "--field", "ranges")
    assert text.count("0.5") == 128
    assert "..." in text
    assert ros2("topic", "echo", "--once", "/Srobot1/description") == "data: a robot\n---\n"
    ros2("topic", "echo", "--once", "/Srobot1/odom", "no_msgs/msg/Nothing", code=1)
    assert "'no_msgs/msg/Nothing' is not installed here" in ros2.err


def measure(verb, topic, count):
    """Return the first lines of a verb that runs until Ctrl-C."""
    command = [sys.executable, "-m", "swarm_ros2", "topic", verb, topic]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=own_path()) as process:
        lines = [process.stdout.readline() for _ in range(count)]
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 2  # ros2cli returns signal.SIGINT
    return lines


def test_bandwidth_delay_and_rate_are_measured():
    lines = measure("bw", "/Srobot1/scan", 3)
    assert lines[0] == "Subscribed to [/Srobot1/scan]\n"
    assert re.fullmatch(r"[\d.]+ KB/s from \d+ messages\n", lines[1])
    size = r"1\.\d\d KB"
    assert re.fullmatch(rf"\tMessage size mean: {size} min: {size} max: {size}\n", lines[2])
    lines = measure("delay", "/Srobot1/odom", 2)
    age = float(lines[0].removeprefix("average delay: "))
    assert abs(age - time.time()) < 100.0  # the sample's stamps are 0
    assert re.fullmatch(r"\tmin: [\d.]+s max: [\d.]+s std dev: [\d.]+s window: \d+\n", lines[1])
    lines = measure("hz", "/Srobot1/scan", 4)
    rate = float(lines[2].removeprefix("average rate: "))
    assert 5.0 < rate < 26.0  # 20, less on a busy machine
    assert lines[3].startswith("\tmin: ")
    assert "window: " in lines[3]


def test_pub_reaches_the_node(ros2):
    command = [
        sys.executable,
        "-m",
        "swarm_ros2",
        "topic",
        "echo",
        "--once",
        "/Srobot1/heard",
        "std_msgs/msg/String",
        "--timeout",
        "30",
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=own_path()) as listener:
        words = ("topic", "pub", "-t", "40", "-r", "10", "/Srobot1/say", "std_msgs/msg/String")
        text = ros2(*words, "data: hello")
        out, _ = listener.communicate(timeout=30)
    assert "publisher: beginning loop\n" in text
    assert "publishing #1: std_msgs.msg.String(data='hello')\n" in text
    assert out == "data: hello\n---\n"


def test_pub_refuses_waits_and_reads_standard_input(ros2, monkeypatch):
    ros2("topic", "pub", "--once", "/x", "std_msgs/msg/String", "{dat: a}", code=1)
    assert "'String' has no field 'dat'; it has data" in ros2.err
    words = ("--once", "--max-wait-time-secs", "0.3", "--node-name", "speaker")
    ros2("topic", "pub", *words, "/nobody_hears", "std_msgs/msg/String", code=1)
    assert "Expected 1 subscribers but only got 0" in ros2.err
    monkeypatch.setattr(sys, "stdin", io.StringIO("data: true\n"))
    text = ros2("service", "call", "/Srobot1/switch", "std_srvs/srv/SetBool", "--stdin")
    assert "SetBool_Request(data=True)" in text
    assert "SUCCEEDED" in ros2("action", "send_goal", "/Srobot1/wait", "nav2_msgs/action/Wait")


def test_nodes_are_listed_and_told(ros2):
    assert ros2("node", "list") == f"{NODE}\n"
    text = ros2("node", "info", NODE)
    assert text.startswith(f"{NODE}\n  Subscribers:\n    /Srobot1/say: std_msgs/msg/String\n")
    assert "    /Srobot1/switch: std_srvs/srv/SetBool\n" in text
    assert "  Action Servers:\n    /Srobot1/wait: nav2_msgs/action/Wait\n" in text
    ros2("node", "info", "/nobody", code=1)
    assert ros2.err == "Unable to find node '/nobody'\n"


def test_services_are_listed_called_counted_and_found(ros2):
    assert "/Srobot1/switch [std_srvs/srv/SetBool]\n" in ros2("service", "list", "-t")
    text = ros2("service", "call", "/Srobot1/switch", "std_srvs/srv/SetBool", "{data: true}")
    assert "requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\n" in text
    expected = "std_srvs.srv.SetBool_Response(success=True, message='as you say')"
    assert f"response:\n{expected}\n" in text
    expected = "Type: std_srvs/srv/SetBool\nClients count: 0\nServices count: 1\n"
    assert ros2("service", "info", "/Srobot1/switch") == expected
    ros2("service", "info", "/nowhere", code=1)
    assert ros2.err == "Unknown service '/nowhere'\n"
    assert ros2("service", "type", "/Srobot1/switch") == "std_srvs/srv/SetBool\n"
    assert ros2("service", "find", "std_srvs/srv/SetBool") == "/Srobot1/switch\n"


def test_action_type_and_info(ros2):
    assert ros2("action", "type", "/Srobot1/wait") == "nav2_msgs/action/Wait\n"
    expected = f"Action: /Srobot1/wait\nAction clients: 0\nAction servers: 1\n    {NODE}\n"
    assert ros2("action", "info", "/Srobot1/wait") == expected


def test_action_list_and_send_goal_with_feedback(ros2):
    assert ros2("action", "list", "-t") == "/Srobot1/wait [nav2_msgs/action/Wait]\n"
    goal = ("/Srobot1/wait", "nav2_msgs/action/Wait", "{time: {sec: 1}}")
    text = ros2("action", "send_goal", "--feedback", *goal)
    parts = (
        "Waiting for an action server",
        "Sending goal:\n     time:\n",
        "Goal accepted with ID: ",
        "Result:\n    total_elapsed_time:\n",
        "Goal finished with status: SUCCEEDED\n",
    )
    places = [text.index(part) for part in parts]
    assert places == sorted(places)
    assert "Feedback:\n    time_left:\n" in text


def test_param_list_get_set(ros2):
    assert "  max_vel_x\n" in ros2("param", "list", NODE)
    assert ros2("param", "set", NODE, "max_vel_x", "0.15") == "Set parameter successful\n"
    assert ros2("param", "get", NODE, "max_vel_x") == "Double value is: 0.15\n"
    assert ros2("param", "get", NODE, "max_vel_x", "--hide-type") == "0.15\n"
    assert "    max_vel_x: 0.15\n" in ros2("param", "dump", NODE)
    assert "  max_vel_x (type: double)\n" in ros2("param", "list", NODE, "--param-type")
    assert "max_vel_x" not in ros2("param", "list", NODE, "--param-prefixes", "qos_overrides")


def test_param_describe_load_and_delete(ros2, tmp_path):
    expected = "Parameter name: max_vel_x\n  Type: double\n  Constraints:\n"
    assert ros2("param", "describe", NODE, "max_vel_x") == expected
    file = tmp_path / "params.yaml"
    file.write_text(f"{NODE}:\n  ros__parameters:\n    max_vel_x: 0.2\n")
    assert ros2("param", "load", NODE, str(file)) == "Set parameter max_vel_x successful\n"
    assert ros2("param", "get", NODE, "max_vel_x", "--hide-type") == "0.2\n"
    file.write_text("/**:\n  ros__parameters:\n    max_vel_x: 0.25\n")
    assert ros2("param", "load", NODE, str(file)) == "Set parameter max_vel_x successful\n"
    ros2("param", "load", NODE, str(file), "--no-use-wildcard", code=1)
    assert "does not contain any valid parameters" in ros2.err
    ros2("param", "delete", NODE, "max_vel_x")
    assert "Deleting parameter failed" in ros2.err  # rclpy: it is statically typed


def test_what_is_wrong_with_a_parameter_is_told(ros2):
    ros2("param", "describe", NODE, "max_vel", code=1)
    assert "unknown parameter 'max_vel'" in ros2.err
    ros2("param", "set", NODE, "max_vel_x", "-1.0", code=1)
    assert ros2.err == "Setting parameter failed: max_vel_x must not be negative\n"
    ros2("param", "set", NODE, "max_vel", "0.1", code=1)
    assert "unknown parameter 'max_vel' in /Srobot1/sample; did you mean 'max_vel_x'?" in ros2.err
    ros2("param", "set", NODE, "max_vel_x", "99", code=1)
    assert ros2.err == "Setting parameter failed: max_vel_x is a double; write 99.0\n"


def test_a_node_that_is_not_there_lists_those_that_are(ros2):
    ros2("param", "get", "/Srobot22/navigator", "max_vel_x", code=1)
    assert ros2.err == "Node not found: /Srobot22/navigator; there are Srobot1\n"
    ros2("param", "get", "/Srobot1/navigator", "max_vel_x", code=1)
    assert ros2.err == "Node not found: /Srobot1/navigator; there are /Srobot1/sample\n"


def test_interface_show_expands_nested_types(ros2):
    text = ros2("interface", "show", "geometry_msgs/msg/PoseStamped", "--no-comments")
    assert text.splitlines()[:4] == [
        "std_msgs/Header header",
        "\tbuiltin_interfaces/Time stamp",
        "\t\tint32 sec",
        "\t\tuint32 nanosec",
    ]


def test_interface_packages_package_and_proto(ros2):
    packages = ros2("interface", "packages").splitlines()
    assert {"std_msgs", "nav2_msgs", "simulation_interfaces"} <= set(packages)
    assert "nav2_msgs" in ros2("interface", "packages", "-a").splitlines()
    assert "std_msgs" not in ros2("interface", "packages", "-a").splitlines()
    assert "std_msgs/msg/String" in ros2("interface", "package", "std_msgs").splitlines()
    assert "    std_msgs/msg/String" in ros2("interface", "list").splitlines()
    ros2("interface", "package", "no_msgs", code=1)
    assert ros2.err == "Unknown package 'no_msgs'\n"
    assert ros2("interface", "proto", "std_msgs/msg/String") == "\"data: ''\n\"\n"
    assert ros2("interface", "proto", "std_srvs/srv/SetBool", "--no-quotes") == "data: false\n\n"


def program(*words):
    command = [sys.executable, "-m", "swarm_ros2", *words]
    return subprocess.run(command, env=own_path(), capture_output=True, text=True, check=False)


def test_run_launch_and_doctor_become_the_program_that_is_meant():
    assert "--swarm-size" in program("run", "swarm_commander", "swarm_up", "--help").stdout
    assert program("run", "swarm_commander", "nothing").stderr == "No executable found\n"
    assert program("run", "no_package", "nothing").stderr == "Package 'no_package' not found\n"
    launch = program("launch", "swarm_commander", "swarm.launch.py", "swarm_size:=none")
    assert launch.returncode == 2
    assert "'none'" in launch.stderr
    assert program("launch", "turtlesim", "multisim.launch.py").returncode == 1
    assert "usage" in program("doctor", "--help").stdout.lower()


def test_real_ros2_is_preferred(tmp_path):
    real = tmp_path / "ros2"
    real.write_text("#!/bin/sh\necho real $*\necho ${LD_LIBRARY_PATH:-none}\n")
    real.chmod(0o755)
    environ = os.environ | {"PATH": f"{tmp_path}{os.pathsep}/usr/bin{os.pathsep}/bin"}
    command = [sys.executable, "-m", "swarm_ros2", "topic", "list"]
    result = subprocess.run(command, env=environ, capture_output=True, text=True, check=True)
    assert result.stdout.splitlines()[0] == "real topic list"
    assert sys.prefix not in result.stdout


def own_path():
    return os.environ | {"PATH": os.path.dirname(sys.executable)}

"""Defaults of the ROS environment, and the discovery profile of robots."""

import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from swarm_common.middleware import dds_profile, ros_env
from swarm_common.model.errors import ConfigError
from tests.fakes.programs import run_program

ROOT = Path(__file__).resolve().parents[4]
LOCATORS = ".//{http://www.eprosima.com}initialPeersList//{http://www.eprosima.com}udpv4"
PORTS = f"{LOCATORS}/{{http://www.eprosima.com}}port"


@pytest.fixture(autouse=True)
def _no_variables(monkeypatch):
    for name in (*ros_env.VARIABLES, "FASTDDS_DEFAULT_PROFILES_FILE", "ROS_DISCOVERY_SERVER"):
        monkeypatch.setenv(name, "")  # so that what a test sets is taken back
        monkeypatch.delenv(name)


def test_our_profile_is_the_default():
    ros_env.set_defaults()
    assert Path(os.environ[ros_env.PROFILES]).name == "fastdds.xml"
    assert os.environ[ros_env.ENDPOINTS] == "1"
    profile = ElementTree.parse(os.environ[ros_env.PROFILES])
    for kind in ("data_writer", "data_reader"):  # or rmw_fastrtps creates no node
        found = profile.findall(f".//{{http://www.eprosima.com}}{kind}[@is_default_profile='true']")
        assert len(found) == 1


@pytest.mark.parametrize(
    ("name", "value"),
    [
        (ros_env.DISCOVERY_RANGE, "SUBNET"),
        ("ROS_DISCOVERY_SERVER", "127.0.0.1:11811"),
        ("FASTDDS_DEFAULT_PROFILES_FILE", "/my/profile.xml"),
    ],
)
def test_the_users_choice_is_respected(name, value, monkeypatch):
    monkeypatch.setenv(name, value)
    ros_env.set_defaults()
    assert os.environ[name] == value
    assert ros_env.PROFILES not in os.environ
    assert ros_env.ENDPOINTS not in os.environ  # nothing is known of the endpoints in his profile


def test_older_ways_to_stay_on_this_host_mean_the_same(monkeypatch):
    """With ROS_LOCALHOST_ONLY=1 shared memory came back, and processes listened to the network."""
    monkeypatch.setenv(ros_env.LOCALHOST_ONLY, "1")
    monkeypatch.setenv(ros_env.DISCOVERY_RANGE, "SUBNET")  # over which it prevails
    ros_env.set_defaults()
    assert ros_env.LOCALHOST_ONLY not in os.environ
    assert os.environ[ros_env.DISCOVERY_RANGE] == "SYSTEM_DEFAULT"
    assert Path(os.environ[ros_env.PROFILES]).name == "fastdds.xml"


def test_a_loopback_interface_that_is_down_is_named(tmp_path):
    """As in a new network namespace: a swarm waited for its navigators for ten minutes."""
    code = (
        "from swarm_common.middleware import ros_env\n"
        "try: ros_env.set_defaults()\n"
        "except Exception as error: print(error)"
    )
    alone = ("unshare", "--map-root-user", "--net")
    if subprocess.run((*alone, "true"), capture_output=True, check=False).returncode:
        pytest.skip("no network namespace can be made here")
    done = run_program((*alone, sys.executable, "-c", code))
    assert "sudo ip link set lo up" in done.stdout, done.stderr


def test_a_profile_in_the_current_folder_is_ignored(tmp_path):
    """Fast DDS reads it beside ours and listened to the network; the run ended with a traceback."""
    (tmp_path / "DEFAULT_FASTRTPS_PROFILES.xml").write_text(
        """<dds xmlns="http://www.eprosima.com"><profiles>
        <participant profile_name="other" is_default_profile="true"><rtps/></participant>
        <data_writer profile_name="writer" is_default_profile="true">
        <qos><reliability><kind>BEST_EFFORT</kind></reliability></qos></data_writer>
        </profiles></dds>""",
        encoding="utf-8",
    )
    code = (
        "from swarm_common.middleware import ros_env; ros_env.set_defaults()\n"
        "import psutil, rclpy; rclpy.init(); node = rclpy.create_node('alone')\n"
        "print({each.laddr.ip for each in psutil.Process().net_connections('udp4')})"
    )
    done = run_program((sys.executable, "-c", code), {"ROS_DOMAIN_ID": "228"}, cwd=tmp_path)
    assert done.stdout == "{'127.0.0.1'}\n", done.stderr


def test_robots_announce_themselves_to_those_they_need_and_to_newcomers(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "3")
    first = 7400 + 250 * 3 + 10
    ros_env.set_defaults()
    path = tmp_path / "fastdds" / "Srobot1.xml"
    ros_env.write_profile(path, (first, first + 8, first + 8), first_free=21)
    found = ElementTree.parse(path).iterfind(PORTS)
    ports = [int(node.text or 0) for node in found]
    assert ports[:2] == [first, first + 8]
    assert ports[2:] == [first + 2 * i for i in range(21, 21 + ros_env.NEWCOMERS)]


@pytest.mark.parametrize("first_free", [105, 113, 119, 120, 243])
def test_nobody_announces_itself_in_the_next_domain(tmp_path, monkeypatch, first_free):
    """100 robots were heard by, and obeyed, the swarm in the next domain; two of them met.

    Nor is the list empty: of 200 packed robots the world's was, and DDS went by its defaults.
    """
    monkeypatch.setenv("ROS_DOMAIN_ID", "30")
    ros_env.set_defaults()
    path = tmp_path / "world.xml"
    ros_env.write_profile(path, (), first_free)
    ports = [int(node.text or 0) for node in ElementTree.parse(path).iterfind(PORTS)]
    assert ports
    assert all(ros_env.is_discovery_port(port) for port in ports)


def test_robots_announce_themselves_on_the_worlds_host(tmp_path, monkeypatch):
    text = dds_profile.profile("10.0.0.2", dds_profile.peers_of_tools("10.0.0.2", "10.0.0.1"), 0)
    (tmp_path / "host.xml").write_text(text, encoding="utf-8")
    monkeypatch.setenv(ros_env.PROFILES, str(tmp_path / "host.xml"))
    assert ros_env.bound_address() == "10.0.0.2"
    assert ros_env.is_large(ros_env.FEW_ROBOTS + 1)
    ros_env.write_profile(tmp_path / "Srobot1.xml", (7410, 7418), 41, "10.0.0.1")
    tree = ElementTree.parse(tmp_path / "Srobot1.xml")
    peers = [(node[0].text, node[1].text) for node in tree.iterfind(LOCATORS)]
    assert peers[:2] == [("7410", "10.0.0.1"), ("7418", "10.0.0.1")]
    assert {address for _, address in peers[2:]} == {"10.0.0.2"}
    monkeypatch.setenv(ros_env.PROFILES, str(tmp_path / "Srobot1.xml"))
    assert ros_env.bound_address() == "10.0.0.2"


@pytest.mark.parametrize("is_copy", [False, True])
def test_our_own_profile_is_not_taken_for_the_users(monkeypatch, tmp_path, is_copy):
    ros_env.set_defaults()
    ours = os.environ[ros_env.PROFILES]
    if is_copy:  # as runs of several hosts make one
        path = tmp_path / "fastdds_host.xml"
        path.write_text(Path(ours).read_text(encoding="utf-8"), encoding="utf-8")
        monkeypatch.setenv(ros_env.PROFILES, str(path))
        ours = str(path)
    monkeypatch.setenv(ros_env.DISCOVERY_RANGE, "LOCALHOST")
    monkeypatch.delenv(ros_env.ENDPOINTS)
    ros_env.set_defaults()
    # With LOCALHOST, rmw_fastrtps would add shared memory to the profile.
    assert os.environ[ros_env.DISCOVERY_RANGE] == "SYSTEM_DEFAULT"
    assert os.environ[ros_env.PROFILES] == ours
    assert os.environ[ros_env.ENDPOINTS] == "1"


def test_with_our_own_profile_given_there_is_no_shared_memory(tmp_path):
    """Another terminal had sourced a run's env.sh; `kill -9` left 23 segments."""
    code = (
        "from swarm_common.middleware import ros_env; ros_env.set_defaults()\n"
        "import rclpy; rclpy.init(); node = rclpy.create_node('alone')\n"
        "print('/dev/shm/fastrtps' in open('/proc/self/maps').read())"
    )
    environment = os.environ | {"ROS_DOMAIN_ID": "228", "PYTHONPATH": str(ROOT)}
    ours = {ros_env.PROFILES: str(dds_profile.TEMPLATE), ros_env.DISCOVERY_RANGE: "LOCALHOST"}
    done = subprocess.run(
        (sys.executable, "-c", code),
        env=environment | ours, cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stdout == "False\n", done.stderr


@pytest.mark.parametrize("home", ["", "/proc/none", "/dev/null"])
def test_rclpy_starts_without_a_home_folder(home, tmp_path):
    code = (
        "from swarm_common.middleware import ros_env; ros_env.set_defaults()\n"
        "from swarm_common.files.storage import cache_folder, kept\n"
        "import os, rclpy; rclpy.init(); rclpy.shutdown()\n"
        "assert kept('t', ['x'], lambda: 3) == 3; print(cache_folder(), os.environ['ROS_LOG_DIR'])"
    )
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ("HOME", "XDG_CACHE_HOME", "ROS_LOG_DIR", "ROS_HOME", "TMPDIR")
    }
    environment |= {"HOME": home} if home else {}
    environment |= {"TMPDIR": str(tmp_path), "ROS_DOMAIN_ID": "228"}
    done = subprocess.run(
        (sys.executable, "-c", code), env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert str(tmp_path) in done.stdout.split()[-1]


@pytest.mark.parametrize("chosen", ["OFF", "off", "everybody"])
def test_a_range_in_which_nobody_is_found_is_refused(monkeypatch, chosen):
    """With OFF a swarm waited for its navigators for ten minutes."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", chosen)
    with pytest.raises(ConfigError, match=f"ROS_AUTOMATIC_DISCOVERY_RANGE is '{chosen}'"):
        ros_env.set_defaults()


def test_security_that_is_enforced_without_keys_is_bad_input(tmp_path, monkeypatch):
    """Every process ended at its start: exit code 3, and a traceback in each log."""
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    ros_env.set_defaults()
    monkeypatch.setenv("ROS_SECURITY_STRATEGY", "Enforce")
    for keys in ("", str(tmp_path)):
        monkeypatch.setenv("ROS_SECURITY_KEYSTORE", keys)
        with pytest.raises(ConfigError, match=f"'{keys}'. is no keystore: unset ROS_SEC"):
            ros_env.set_defaults()
    (tmp_path / "enclaves").mkdir()
    ros_env.set_defaults()

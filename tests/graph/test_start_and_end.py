"""Start without autostart, bad input of the two processes, and an end that leaves nothing."""

import json
import os
import signal

import psutil
import pytest
import yaml
from lifecycle_msgs.srv import GetState
from nav2_msgs.srv import ManageLifecycleNodes

from tests.graph.conftest import START_LIMIT, Process, parameters


@pytest.fixture(scope="module")
def sleeping(start_swarm):
    return start_swarm(1, autostart=False, world={"duration": None, "speed": "max"})


def test_without_autostart_a_robot_answers_but_waits_for_startup(sleeping):
    def state():
        return sleeping.call(GetState, "/Srobot1/amcl/get_state", GetState.Request())

    sleeping.spin_until(lambda: sleeping.sim_time() > 1.0, 60.0)  # it answers all the same
    assert state().current_state.label == "unconfigured"
    assert sleeping.host.named("active") == []
    request = ManageLifecycleNodes.Request(command=ManageLifecycleNodes.Request.STARTUP)
    name = "/Srobot1/lifecycle_manager_navigation/manage_nodes"
    assert sleeping.call(ManageLifecycleNodes, name, request).success
    assert state().current_state.label == "active"
    sleeping.host.wait_for("active")


def test_the_fork_server_has_one_thread_so_that_no_fork_copies_a_lock_of_another(sleeping):
    assert psutil.Process(sleeping.host.popen.pid).num_threads() == 1
    assert "was forked beside" not in (sleeping.folder / "host.log").read_text(encoding="utf-8")


def test_navigators_do_not_interrupt_each_other(sleeping):
    assert os.sched_getscheduler(sleeping.pid_of("Srobot1")) == os.SCHED_BATCH


def test_the_world_writes_its_verdict_and_nobody_survives_the_fork_server(sleeping):
    """Last for this swarm: it is ended here, the fork server with a SIGKILL."""
    sleeping.host.wait_for("active")
    navigator = psutil.Process(sleeping.pid_of("Srobot1"))
    sleeping.host.popen.send_signal(signal.SIGKILL)
    navigator.wait(timeout=20.0)
    assert sleeping.world.end() == 0
    verdict = json.loads((sleeping.folder / "verdict.json").read_text(encoding="utf-8"))
    assert verdict["ticks"] > 10
    assert len(verdict["trajectory_sha256"]) == 64


def test_the_fork_server_refuses_bad_parameters(tmp_path):
    values = parameters(1, [0.0, 0.0, 0.0]) | {"max_val_x": 0.2}
    path = tmp_path / "Srobot1.yaml"
    tree = {"/Srobot1/navigator": {"ros__parameters": values}}
    path.write_text(yaml.safe_dump(tree), encoding="utf-8")
    config = tmp_path / "host.json"
    robots = [{"name": "Srobot1", "params": str(path)}]
    config.write_text(json.dumps({"robots": robots}), encoding="utf-8")
    domain = int(os.environ["ROS_DOMAIN_ID"])
    host = Process("swarm_nav.launch.fork_server_main", config, domain, tmp_path / "log")
    assert host.popen.wait(START_LIMIT) == 2
    assert "did you mean 'max_vel_x'" in host.named("error")[0]["message"]
    host.end()


def test_the_world_refuses_an_unknown_world(tmp_path):
    config = tmp_path / "world.json"
    robots = [{"name": "Srobot1", "model": "turtlebot3_waffle"}]
    config.write_text(json.dumps({"world": "slim_blokage", "robots": robots}), encoding="utf-8")
    domain = int(os.environ["ROS_DOMAIN_ID"])
    world = Process("swarm_sim.ros.node", config, domain, tmp_path / "log")
    assert world.popen.wait(START_LIMIT) == 2
    assert "did you mean 'slim_blockage'?" in world.named("error")[0]["message"]
    world.end()

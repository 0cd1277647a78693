"""Several navigators in one process: each its own node, and its own failure."""

import os
import signal

ROBOTS = 3
OPTIONS = dict(pack=3, fork_server="tests.fakes.failing_host")


def navigators_in(swarm):
    return {name for name in swarm.node.get_node_names_and_namespaces() if name[0] == "navigator"}


def test_a_pack_is_one_process_with_a_node_for_each_robot(swarm):
    pids = {event["pid"] for event in swarm.host.named("active")}
    assert len(pids) == 1
    assert os.getpid() not in pids
    expected = {("navigator", f"/{name}") for name in swarm.names}
    swarm.spin_until(lambda: navigators_in(swarm) == expected)


def test_one_that_fails_leaves_the_others_alone(swarm):
    os.kill(swarm.pid_of("Srobot2"), signal.SIGUSR1)
    swarm.host.wait_for("died")
    assert swarm.host.named("died") == [{"event": "died", "robot": "Srobot2", "returncode": 1}]
    os.write(swarm.world.control_fd, b'{"cmd": "dead", "robot": "Srobot2"}\n')
    before = swarm.sim_time()
    swarm.spin_until(lambda: swarm.sim_time() > before + 2.0)
    others = {("navigator", "/Srobot1"), ("navigator", "/Srobot3")}
    swarm.spin_until(lambda: navigators_in(swarm) == others)
    assert "ZeroDivisionError" in (swarm.folder / "Srobot1.log").read_text(encoding="utf-8")

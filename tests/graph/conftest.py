"""Real world and navigator processes for the graph tests, in a ROS domain of their own."""

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import pytest
import rclpy
import yaml
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from swarm_common.files.resources import share_directory
from swarm_common.model.robot_names import RobotNames
from swarm_common.model.robot_parameters import frames_parameter, robot_parameters
from swarm_common.process.lifetime import die_with
from swarm_describe.robots.loading import fixed_frames, load_robot
from swarm_describe.worlds.world_file import find_world
from swarm_nav.core.config import NavConfig, parameter_values
from tests.fakes.real_swarm import start  # noqa: F401
from tests.fakes.ros_domains import reserved_domain

ROBOT = "turtlebot3_waffle"
WORLD = "slim_blockage"
START_LIMIT = 90.0  # [s] of wall time, on a busy machine


class Process:
    """The world or the fork server, with its events."""

    def __init__(self, module, config, domain, log):
        self.events: list[dict[str, Any]] = []
        reading, writing = os.pipe()
        control, self.control_fd = os.pipe()
        os.set_blocking(reading, False)
        self._partial = b""
        self._reading = reading
        self._log = log
        flags = ("--event-fd", str(writing), "--control-fd", str(control))
        parent = os.getpid()
        with log.open("wb") as output:
            self.popen = subprocess.Popen(
                (sys.executable, "-m", module, str(config), *flags),
                env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
                stdout=output,
                stderr=subprocess.STDOUT,
                pass_fds=(writing, control),
                preexec_fn=lambda: die_with(parent),
                start_new_session=True,
            )
        os.close(writing)
        os.close(control)

    def read(self, timeout=0.0):
        """Return all events so far, after waiting for new ones for a while."""
        select.select([self._reading], [], [], timeout)
        with contextlib.suppress(BlockingIOError):
            while chunk := os.read(self._reading, 65536):
                self._partial += chunk
        *lines, self._partial = self._partial.split(b"\n")
        self.events += [json.loads(line) for line in lines]
        return self.events

    def named(self, kind):
        return [event for event in self.read() if event["event"] == kind]

    def wait_for(self, kind, count=1, limit=START_LIMIT):
        """Wait until there are `count` events of a kind."""
        end = time.monotonic() + limit
        while len(self.named(kind)) < count:
            assert time.monotonic() < end, f"no {count} events '{kind}': {self.events}"
            code = self.popen.poll()
            assert code is None, f"ended with {code}: {self._log.read_text(encoding='utf-8')}"
            assert kind == "died" or not self.named("died"), self.events
            self.read(0.2)

    def end(self):
        """Ask it to end and return its exit code."""
        if self.popen.poll() is None:
            self.popen.terminate()
        try:
            return self.popen.wait(20.0)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.popen.pid, signal.SIGKILL)
            for descriptor in (self._reading, self.control_fd):
                with contextlib.suppress(OSError):
                    os.close(descriptor)


class Swarm:
    """A world and its navigators, and a node of our own to talk to them."""

    def __init__(self, folder, domain, count, **options):
        self.robot_names: RobotNames = options.pop("names", RobotNames())
        self.names = self.robot_names.first(count)
        self.domain = domain
        self.folder = folder
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node: Node = rclpy.create_node("tester", context=self.context, enable_rosout=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.pack = options.pop("pack", 1)
        self.fork_server = options.pop("fork_server", "swarm_nav.launch.fork_server_main")
        self.world = self._start_world(options.pop("world", {}))
        self.host = self._start_host(options)

    def _start_world(self, changes):
        config = {
            "world": WORLD,
            "robots": [{"name": name, "model": ROBOT} for name in self.names],
            "pattern": self.robot_names.pattern,
            "speed": 4.0,
            "verdict_path": str(self.folder / "verdict.json"),
        }
        path = self.folder / "world.json"
        path.write_text(json.dumps(config | changes), encoding="utf-8")
        return Process("swarm_sim.ros.node", path, self.domain, self.folder / "world.log")

    def _start_host(self, changes):
        self.world.wait_for("spawn")
        spawn = self.world.named("spawn")[0]
        by_robot = changes.pop("by_robot", {})
        poses, digest = spawn["poses"], spawn["map_sha256"]
        robots = []
        for number, (name, pose) in enumerate(zip(self.names, poses, strict=True), 1):
            path = self.folder / f"{name}.yaml"
            own = {"map_sha256": digest, "robot_names": str(self.robot_names)}
            values = parameters(number, pose) | own | changes
            values |= by_robot.get(name, {})
            tree = {f"/{name}/navigator": {"ros__parameters": values}}
            path.write_text(yaml.safe_dump(tree), encoding="utf-8")
            robots.append({"name": name, "params": str(path)})
        path = self.folder / "host.json"
        config = {"robots": robots, "pack": self.pack, "log_dir": str(self.folder)}
        path.write_text(json.dumps(config), encoding="utf-8")
        return Process(self.fork_server, path, self.domain, self.folder / "host.log")

    def wait_until_active(self):
        self.host.wait_for("active", len(self.names))
        self.spin_until(lambda: self.sim_time() > 0.0, START_LIMIT)

    def sim_time(self):
        progress = self.world.named("progress")
        return float(progress[-1]["sim_time"]) if progress else 0.0

    def spin(self, period):
        end = time.monotonic() + period
        while time.monotonic() < end:
            self.executor.spin_once(timeout_sec=0.05)

    def spin_until(self, condition, limit=30.0):
        end = time.monotonic() + limit
        while not condition():
            assert time.monotonic() < end, "waited in vain"
            self.executor.spin_once(timeout_sec=0.05)

    def result_of(self, future, limit=30.0):
        self.spin_until(future.done, limit)
        return future.result()

    def call(self, kind, name, request):
        """Call a service once."""
        client = self.node.create_client(kind, name)
        try:
            assert client.wait_for_service(20.0), f"no service {name}"
            return self.result_of(client.call_async(request))
        finally:
            self.node.destroy_client(client)

    def pid_of(self, name):
        return next(int(e["pid"]) for e in self.host.named("active") if e["robot"] == name)

    def close(self):
        """End everything, whatever state it is in."""
        try:
            self.executor.shutdown()
            self.node.destroy_node()
            self.context.try_shutdown()
        finally:
            self.world.end()
            self.host.end()


def parameters(robot_id, pose, model=ROBOT):
    """Return the parameters of one navigator by dotted name."""
    spec = load_robot(model)
    limits = ("max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta")
    sites = find_world(WORLD, "sites.yaml")
    return (
        parameter_values(NavConfig())
        | {name: getattr(spec, name) for name in limits}
        | {f"robot.{name}": value for name, value in robot_parameters(spec).items()}
        | {"frames": frames_parameter(fixed_frames(model))}
        | dict(zip(("initial_pose.x", "initial_pose.y", "initial_pose.yaw"), pose, strict=True))
        | {"robot_id": robot_id, "sites": str(sites)}
    )


StartSwarm = Callable[..., Swarm]


@pytest.fixture(scope="module")
def start_swarm(tmp_path_factory):
    """Yield a function that starts a swarm; all of them end with the module."""
    assert (share_directory() / "worlds").is_dir()
    with contextlib.ExitStack() as stack:

        def start(count, **options):
            domain = stack.enter_context(reserved_domain())
            swarm = Swarm(tmp_path_factory.mktemp("swarm"), domain, count, **options)
            stack.callback(swarm.close)
            return swarm

        yield start


@pytest.fixture(scope="module")
def swarm(start_swarm, request):
    module = request.module
    started = start_swarm(getattr(module, "ROBOTS", 2), **getattr(module, "OPTIONS", {}))
    started.wait_until_active()
    return started

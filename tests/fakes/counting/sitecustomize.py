"""Counts what a process of the swarm does on the ROS graph; found first on PYTHONPATH.

Python imports it at the start of every process of a run. Counts go to a file per process in the
folder `SWARM_COUNTS`, mapped into memory, so that they outlive any end of the process.
"""

import functools
import importlib.abc
import importlib.machinery
import mmap
import os
import struct
import sys

NAMES = ("published", "taken", "wake_ups", "executor_waits", "endpoints")
SIZE = 8 * len(NAMES)
FOLDER = os.environ.get("SWARM_COUNTS", "")
SERVICE, ACTION = 2, 8  # DDS endpoints of a service or client, and of an action server or client


class Counts:
    """The counters of this process."""

    def open(self):
        path = os.path.join(FOLDER, f"counts-{os.getpid()}")
        with open(path, "w+b") as file:
            file.truncate(SIZE)
            self._memory = mmap.mmap(file.fileno(), SIZE)

    def add(self, name, amount=1):
        offset = 8 * NAMES.index(name)
        (value,) = struct.unpack_from("q", self._memory, offset)
        struct.pack_into("q", self._memory, offset, value + amount)


COUNTS = Counts()


def counted(kind, method, name, amount=1, *, only_results=False):
    """Let each call of a method count."""
    original = getattr(kind, method)

    @functools.wraps(original)
    def call(*args, **kwargs):
        result = original(*args, **kwargs)
        if result is not None or not only_results:
            COUNTS.add(name, amount)
        return result

    setattr(kind, method, call)


def patch_poll(module):
    counted(module.PolledTopic, "__init__", "endpoints")
    counted(module.PolledService, "__init__", "endpoints", SERVICE)
    notice_wake_ups(module)


def notice_wake_ups(module):
    """Count messages, and the wait sets that were filled for one: not those that timed out."""
    wait, take = module.Waiter.wait, module.PolledTopic.take
    has_waited = [False]

    def waited(self, *args):
        wait(self, *args)
        has_waited[0] = True

    def taken(self):
        message = take(self)
        if message is not None:
            COUNTS.add("taken")
            COUNTS.add("wake_ups", int(has_waited[0]))
            has_waited[0] = False
        return message

    module.Waiter.wait, module.PolledTopic.take = waited, taken


def patch_node(module):
    counted(module.Node, "create_publisher", "endpoints")
    counted(module.Node, "create_subscription", "endpoints")
    counted(module.Node, "create_service", "endpoints", SERVICE)
    counted(module.Node, "create_client", "endpoints", SERVICE)


PATCHES = {
    "swarm_common.middleware.ros_poll": patch_poll,
    "rclpy.node": patch_node,
    "rclpy.publisher": lambda module: counted(module.Publisher, "publish", "published"),
    "rclpy.executors": lambda module: counted(
        module.Executor, "_wait_for_ready_callbacks", "executor_waits"
    ),
    "rclpy.action.server": lambda module: counted(
        module.ActionServer, "__init__", "endpoints", ACTION
    ),
    "rclpy.action.client": lambda module: counted(
        module.ActionClient, "__init__", "endpoints", ACTION
    ),
}


class Patcher(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Loads the modules of `PATCHES` as usual and patches them."""

    def find_spec(self, name, path=None, target=None):
        if name not in PATCHES:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if spec is not None and spec.loader is not None:
            spec.loader.exec_module = functools.partial(self._load, spec.loader.exec_module, name)
        return spec

    @staticmethod
    def _load(execute, name, module):
        execute(module)
        PATCHES[name](module)


if FOLDER:
    COUNTS.open()
    os.register_at_fork(after_in_child=COUNTS.open)
    sys.meta_path.insert(0, Patcher())

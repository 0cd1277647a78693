"""Throws malformed inputs at a running swarm: `python -m tests.fuzz_live --count 100000 --seed 0`.

Every topic that a world or a navigator subscribes to, every service, every action and every
parameter gets, in an order that the seed decides,

- messages of the right shape with absurd values: 1e308, NaN, counts of 2^32-1, texts of 100 kB;
- bytes that are no message: real ones cut off, with bits turned, of the other byte order, with
  counts that promise more than there is, and noise. What the swarm itself sends serves as a
  pattern, so that stamps and frames are those of the tick in hand.

Meanwhile the robots drive to real goals. At the end no process may have died, no tick may have
waited longer than `TICK_LIMIT`, nobody may have collided, and memory must be flat. Requests as raw
bytes are left out: rclpy cannot send any.
"""

import argparse
import contextlib
import importlib
import itertools
import json
import math
import random
import sys
import tempfile
import time
import warnings
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import psutil
from nav2_msgs.action import (
    BackUp,
    ComputePathThroughPoses,
    ComputePathToPose,
    DriveOnHeading,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
    Wait,
)
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from swarm_interfaces.msg import Mission

from swarm_common.middleware import ros_env
from swarm_common.middleware.rclpy_compat import SafeExecutor
from swarm_common.middleware.ros_io import pose_stamped
from swarm_common.middleware.ros_poll import PolledTopic, drain
from swarm_common.model.records import Pose
from tests.fakes.ros_domains import reserved_domain
from tests.graph.conftest import Swarm

ROBOTS = 3
SPEED = 4.0  # times real time
BATCH = 20  # inputs between two looks at what comes back
RATE = 300.0  # inputs per second of wall time, at most
TICK_LIMIT = 1.0  # [s] of wall time
MOST_PENDING = 300  # requests whose answers are waited for
SETTLED = 4.0  # [s] of wall time without new topics and services
GROWTH = 30.0  # [MB] of a process between the middle and the end
GOAL_PERIOD = 3.0  # [s] of wall time between two real goals of a robot
GOALS = ((-2.7, 0.0), (2.0, 2.0), (0.0, 7.0), (6.0, 3.0), (2.0, -3.5), (-2.7, 6.0))
ACTIONS = {
    "navigate_to_pose": NavigateToPose,
    "navigate_through_poses": NavigateThroughPoses,
    "follow_waypoints": FollowWaypoints,
    "follow_path": FollowPath,
    "compute_path_to_pose": ComputePathToPose,
    "compute_path_through_poses": ComputePathThroughPoses,
    "spin": Spin,
    "backup": BackUp,
    "drive_on_heading": DriveOnHeading,
    "wait": Wait,
}
BOX = (
    '<sdf version="1.7"><model name="box"><link name="l"><collision name="c"><geometry><box>'
    "<size>0.3 0.3 0.3</size></box></geometry></collision></link></model></sdf>"
)
FLOATS = (
    0.0, 1.0, -1.0, 1e308, -1e308, math.inf, -math.inf, math.nan, 1e9, -1e9, 5e-324, 3e38, 0.5,
    1e-9, 4e4, 2.0**63, math.pi,
)  # fmt: skip
TEXTS = (
    "", "map", "odom", "base_link", "spawn", "ground", "x" * 5000, "x" * 100_000, "\n", "\x1b[2J",
    "(" * 200, "(a+)+$", "[" * 100, "Srobot9", "nobody", "/", "../../../etc", "file:///dev/zero",
    "/dev/stdin", "turtlebot9", "%s%n", "\u202e", "ä" * 300, BOX, "<sdf", "<robot/>", "speed",
)  # fmt: skip
LENGTHS = (0, 0, 1, 2, 3, 17, 2000)
# Requests that are in order and mean harm: what an operator may do is no malformed input.
HARMLESS = {"state": (0, 1, 3, 77, 255), "command": (0, 2, 5, 77, 255)}


def is_order(data: bytes, kind: type) -> bool:
    """Whether bytes are an operator's mission: for its next goal the swarm waits, up to 10 s."""
    with contextlib.suppress(Exception):
        return kind is Mission and deserialize_message(data, kind).active
    return False


class Inventor:
    """Makes up values for the fields of messages."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._types: dict[str, type] = {}

    def message(self, kind: Any) -> Any:
        """Return a message of a type with absurd values in about half of its fields."""
        message = kind()
        share = self._rng.choice((0.1, 0.5, 1.0))
        for name, text in message.get_fields_and_field_types().items():
            if self._rng.random() < share or "/" in text:
                with contextlib.suppress(AssertionError, OverflowError, TypeError, ValueError):
                    setattr(message, name, self._value(name, text, getattr(message, name)))
        return message

    def _value(self, name: str, text: str, old: Any) -> Any:
        rng = self._rng
        if text.startswith("sequence<"):
            inner = text.removeprefix("sequence<").rpartition(">")[0].partition(",")[0].strip()
            is_plain = not ("/" in inner or inner.startswith(("string", "wstring")))
            count = rng.choice(LENGTHS if is_plain else LENGTHS[:5])  # some MB at most
            return [self._value(name, inner, None) for _ in range(count)]
        if text.endswith("]"):
            inner, _, count = text[:-1].rpartition("[")
            return [self._value(name, inner, None) for _ in range(int(count))]
        if "/" in text:
            return self.message(self._class(text) if old is None else type(old))
        if text.startswith(("string", "wstring")):
            return rng.choice(TEXTS)
        if text in ("float", "double"):
            return rng.choice(FLOATS) if rng.random() < 0.8 else rng.uniform(-10.0, 10.0)
        if text == "boolean":
            return rng.random() < 0.5
        return self._integer(name, text, old)

    def _integer(self, name: str, text: str, old: Any) -> int:
        if name in HARMLESS:
            return self._rng.choice(HARMLESS[name])
        if text in ("octet", "byte", "char"):
            return self._rng.randrange(128)
        bits = int(text.removeprefix("u").removeprefix("int"))
        low, high = (
            (0, 2**bits - 1) if text[0] == "u" else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
        )
        return self._rng.choice((low, high, 0, 1, high // 2, self._rng.randint(low, high)))

    def _class(self, text: str) -> type:
        if text not in self._types:
            package, name = text.split("/")
            self._types[text] = getattr(importlib.import_module(f"{package}.msg"), name)
        return self._types[text]


def mutated(rng: random.Random, data: bytes) -> bytes:
    """Return bytes like those of a message, but wrong somewhere."""
    raw = bytearray(data)
    way = rng.randrange(9)
    if way == 0 or len(raw) < 8:
        return rng.randbytes(rng.choice((0, 1, 3, 4, 5, 8, 64, 5000)))
    if way == 1:
        return bytes(raw[: rng.randrange(len(raw))])
    if way == 2:  # big endian, as DDS allows
        return b"\x00\x00\x00\x00" + bytes(raw[4:])
    if way == 3:  # another encapsulation
        return bytes([rng.randrange(256), rng.randrange(256)]) + bytes(raw[2:])
    if way == 4:  # a count, or anything of 4 bytes
        at = 4 + 4 * rng.randrange((len(raw) - 4) // 4)
        raw[at : at + 4] = rng.choice((b"\xff" * 4, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0" * 4))
        return bytes(raw)
    if way == 5:  # numbers that are none, from somewhere on
        at = 4 + 4 * rng.randrange((len(raw) - 4) // 4)
        return bytes(raw[:at]) + rng.choice((b"\0\0\xc0\x7f", b"\xff" * 4)) * ((len(raw) - at) // 4)
    if way == 6:  # stamp
        raw[4:12] = rng.choice((b"\xff\xff\xff\x7f" * 2, b"\0\0\0\x80" * 2, b"\xff" * 8))
        return bytes(raw)
    if way == 7:
        return bytes(raw) + rng.randbytes(rng.choice((1, 100, 60_000)))
    for _ in range(rng.choice((1, 8, 64))):
        raw[rng.randrange(4, len(raw))] ^= 1 << rng.randrange(8)
    return bytes(raw)


@dataclass(slots=True)
class Target:
    """What inputs are thrown at.

    Attributes:
        name: Of the topic, service or parameter's node.
        throw: Sends one input; returns what it was.
    """

    name: str
    throw: Callable[[], str]


@dataclass(slots=True)
class Outcome:
    """What came of it."""

    sent: Counter[str] = field(default_factory=Counter)
    answered: int = 0
    unanswered: int = 0
    worst_tick: float = 0.0  # [s] of wall time between two ticks
    slow_ticks: int = 0  # above the limit
    ticks: int = 0
    memory: list[dict[str, float]] = field(default_factory=list)  # [MB] by process
    problems: list[str] = field(default_factory=list)
    wall_time: float = 0.0


class Fuzzer:
    """Throws inputs at a swarm."""

    def __init__(
        self, swarm: Swarm, seed: int, only: str = "", tick_limit: float = TICK_LIMIT
    ) -> None:
        self.outcome = Outcome()
        self._log = (swarm.folder / "inputs.log").open("w", encoding="utf-8", errors="replace")
        self._swarm = swarm
        self._tick_limit = tick_limit
        self._rng = random.Random(seed)
        self._inventor = Inventor(self._rng)
        self._patterns: dict[str, bytes] = {}  # by topic: what the swarm sent last
        self._pending: deque[tuple[Any, Any]] = deque()
        self._recent: deque[tuple[float, str]] = deque(maxlen=2000)  # when, what
        self._slowest: list[str] = []  # inputs before the slowest tick was seen
        self._last_tick = 0  # [ns] of wall time
        self._goal_due = 0.0
        self._executor = SafeExecutor(context=swarm.context)
        swarm.executor.remove_node(swarm.node)
        self._executor.add_node(swarm.node)
        self._drivers = self._make_drivers()
        quality = QoSProfile(depth=2000)
        self._ticks = PolledTopic(swarm.node, Odometry, "/Srobot1/ground_truth", quality)
        self._wait_for_graph()
        self._targets = [
            target
            for target in itertools.chain(self._topics(), self._services(), self._parameters())
            if only in target.name
        ]
        self._listen(3.0)

    @property
    def names(self) -> list[str]:
        """What is fuzzed."""
        return [target.name for target in self._targets]

    def _listen(self, period: float) -> None:
        end = time.monotonic() + period
        while time.monotonic() < end:
            drain(self._executor)
            time.sleep(0.01)

    def _wait_for_graph(self) -> None:
        """Wait until nothing more appears, so that a seed means the same each time."""
        node, known, since = self._swarm.node, 0, time.monotonic()
        while time.monotonic() < since + SETTLED:
            self._listen(0.2)
            found = len(node.get_topic_names_and_types()) + len(node.get_service_names_and_types())
            if found != known:
                known, since = found, time.monotonic()

    # What there is to throw at

    def _topics(self) -> list[Target]:
        node = self._swarm.node
        found = []
        for name, types in sorted(node.get_topic_names_and_types()):
            heard = [info.node_name for info in node.get_subscriptions_info_by_topic(name)]
            if any(who != node.get_name() for who in heard):
                package, _, kind = types[0].split("/")
                found.append((name, getattr(importlib.import_module(f"{package}.msg"), kind)))
        return [self._topic(name, kind) for name, kind in found if "_action" not in name]

    def _topic(self, name: str, kind: Any) -> Target:
        node, rng = self._swarm.node, self._rng
        offers = node.get_publishers_info_by_topic(name)
        is_latched = any(
            info.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL
            for info in (*offers, *node.get_subscriptions_info_by_topic(name))
        )
        durable = DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE
        quality = QoSProfile(depth=10, durability=durable)

        def keep(data: bytes) -> None:
            self._patterns[name] = bytes(data)

        if offers:
            listening = QoSProfile(
                depth=1, durability=durable, reliability=ReliabilityPolicy.BEST_EFFORT
            )
            node.create_subscription(kind, name, keep, listening, raw=True)
        publisher = node.create_publisher(kind, name, quality)

        def throw() -> str:
            if rng.random() < 0.4:
                message = self._inventor.message(kind)
                if not is_order(serialize_message(message), kind):
                    publisher.publish(message)
                return f"{name}: {str(message)[:300]}"
            pattern = self._patterns.get(name)
            if pattern is None or rng.random() < 0.3:
                pattern = serialize_message(self._inventor.message(kind))
            data = mutated(rng, pattern)
            if is_order(data, kind):
                return f"{name}: nothing"
            with contextlib.suppress(RuntimeError):  # DDS itself sends no empty message
                publisher.publish(data)
            return f"{name}: {len(data)} bytes {data[:80].hex()}"

        return Target(name, throw)

    def _services(self) -> list[Target]:
        node = self._swarm.node
        targets = []
        for name, types in sorted(node.get_service_names_and_types()):
            package, _, kind = types[0].split("/")
            if "_action" not in name and not name.startswith("/tester"):
                module = importlib.import_module(f"{package}.srv")
                targets.append(self._service(name, getattr(module, kind)))
        for robot in self._swarm.names:
            for action, kind in ACTIONS.items():
                space = f"/{robot}/{action}/_action"
                for name, service in (
                    ("send_goal", kind.Impl.SendGoalService),
                    ("get_result", kind.Impl.GetResultService),
                    ("cancel_goal", kind.Impl.CancelGoalService),
                ):
                    targets.append(self._service(f"{space}/{name}", service))
        return targets

    def _service(self, name: str, kind: Any) -> Target:
        client = self._swarm.node.create_client(kind, name)

        def throw() -> str:
            request = self._inventor.message(kind.Request)
            self._ask(client, request)
            return f"{name}: {str(request)[:300]}"

        return Target(name, throw)

    def _parameters(self) -> list[Target]:
        from rcl_interfaces.msg import Parameter
        from rcl_interfaces.srv import ListParameters, SetParameters

        targets = []
        for space in ("/sim/world", *(f"/{robot}/navigator" for robot in self._swarm.names)):
            lister = self._swarm.node.create_client(ListParameters, f"{space}/list_parameters")
            if not lister.wait_for_service(5.0):
                continue
            future = lister.call_async(ListParameters.Request())
            end = time.monotonic() + 20.0
            while not future.done() and time.monotonic() < end:
                self._listen(0.05)
            names = sorted(future.result().result.names)
            client = self._swarm.node.create_client(SetParameters, f"{space}/set_parameters")

            def throw(space: str = space, names: list[str] = names, client: Any = client) -> str:
                parameter = self._inventor.message(Parameter)
                parameter.name = self._rng.choice(names)
                parameter.value.type = self._rng.choice((1, 2, 3, 3, 3, 4, 8, 9, 200))
                self._ask(client, SetParameters.Request(parameters=[parameter]))
                return f"{space}: {parameter.name}: {str(parameter.value)[:200]}"

            targets.append(Target(f"{space}/set_parameters of known names", throw))
        return targets

    def _ask(self, client: Any, request: Any) -> None:
        while len(self._pending) >= MOST_PENDING:
            self._settle_oldest()
        self._pending.append((client, client.call_async(request)))

    def _settle_oldest(self) -> None:
        client, future = self._pending.popleft()
        if future.done():
            self.outcome.answered += 1
        else:
            self.outcome.unanswered += 1
            client.remove_pending_request(future)

    # What goes on meanwhile

    def _make_drivers(self) -> list[Any]:
        kind = NavigateToPose.Impl.SendGoalService
        space = "navigate_to_pose/_action/send_goal"
        return [
            self._swarm.node.create_client(kind, f"/{robot}/{space}") for robot in self._swarm.names
        ]

    def _drive(self) -> None:
        """Send each robot to another place now and then."""
        if time.monotonic() < self._goal_due:
            return
        self._goal_due = time.monotonic() + GOAL_PERIOD
        places = self._rng.sample(GOALS, len(self._drivers))
        for client, (x, y) in zip(self._drivers, places, strict=True):
            request = NavigateToPose.Impl.SendGoalService.Request()
            request.goal_id.uuid = list(self._rng.randbytes(16))
            request.goal.pose = pose_stamped(Pose(x, y, 0.0), 0)
            self._ask(client, request)

    def _watch_ticks(self) -> None:
        """Measure the time between two ticks by when the world sent them, not by when we look."""
        while (taken := self._ticks.handle.take_message(Odometry, True)) is not None:
            stamp = taken[1]["source_timestamp"]
            if self._last_tick and stamp > self._last_tick:
                self._note_gap(1e-9 * (stamp - self._last_tick))
            self.outcome.ticks += 1
            self._last_tick = stamp

    def _note_gap(self, gap: float) -> None:
        outcome = self.outcome
        outcome.slow_ticks += gap > self._tick_limit
        if gap > outcome.worst_tick:
            outcome.worst_tick = gap
            since = time.monotonic() - gap - 1.0  # what is slow may have waited before it began
            self._slowest = [text for at, text in self._recent if at > since]

    # The run

    def run(self, count: int) -> Outcome:
        """Throw a number of inputs; return what came of it."""
        outcome, started = self.outcome, time.monotonic()
        self._watch_ticks()
        outcome.worst_tick, outcome.slow_ticks, outcome.ticks = 0.0, 0, 0
        outcome.memory.append(self._memory())
        marks = {count // 10, count // 2}
        for number in range(count):
            target = self._rng.choice(self._targets)
            self._recent.append((time.monotonic(), target.throw()))
            self._log.write(f"{time.time():.3f} {self._recent[-1][1]!r}\n")
            outcome.sent[target.name.replace("Srobot1", "K")] += 1
            if number in marks:
                outcome.memory.append(self._memory())
            if number % BATCH == 0 and not self._look(started, number):
                break
        while self._pending:
            self._settle_oldest()
        self._listen(1.0)
        self._watch_ticks()
        self._note_gap(time.time() - 1e-9 * self._last_tick)
        outcome.memory.append(self._memory())
        outcome.wall_time = time.monotonic() - started
        self._judge()
        return outcome

    def _look(self, started: float, number: int) -> bool:
        """Take what came back; return whether all processes live."""
        drain(self._executor)
        self._watch_ticks()
        self._drive()
        ahead = started + number / RATE - time.monotonic()
        if ahead > 0.0:
            time.sleep(ahead)
        swarm = self._swarm
        swarm.world.read()  # or it waits for us, as its pipe is full
        for process, name in ((swarm.world, "world"), (swarm.host, "fork_server")):
            if process.popen.poll() is not None:
                self.outcome.problems.append(f"the {name} ended: {process.popen.returncode}")
        for event in swarm.host.named("died"):
            self.outcome.problems.append(f"{event['robot']} died: {event}")
        if self.outcome.problems:
            self.outcome.problems += [f"after {number} inputs, the last of which:"]
            self.outcome.problems += [text for _, text in list(self._recent)[-60:]]
        return not self.outcome.problems

    def _memory(self) -> dict[str, float]:
        pids = {"world": self._swarm.world.popen.pid}
        pids |= {name: self._swarm.pid_of(name) for name in self._swarm.names}
        memory = {}
        for name, pid in pids.items():
            with contextlib.suppress(psutil.NoSuchProcess):
                memory[name] = round(psutil.Process(pid).memory_info().rss / 2**20, 1)
        return memory

    def _judge(self) -> None:
        outcome, problems = self.outcome, self.outcome.problems
        if problems:
            return
        if outcome.worst_tick > self._tick_limit:
            problems.append(f"a tick took {outcome.worst_tick:.2f} s of wall time; before it:")
            problems += self._slowest
        if len(outcome.memory) >= 4:
            middle, end = outcome.memory[2], outcome.memory[-1]
            for name, size in end.items():
                if size - middle[name] > GROWTH:
                    problems.append(f"{name} grew from {middle[name]} to {size} MB")
        progress = self._swarm.world.named("progress")
        if progress and any(progress[-1]["collisions"].values()):
            problems.append(f"collisions: {progress[-1]['collisions']}")
            problems += [str(event) for event in self._swarm.world.named("collision")]


def fuzz(
    folder: Path, count: int, seed: int, only: str = "", tick_limit: float = TICK_LIMIT
) -> Outcome:
    """Start a swarm, throw inputs at it, end it; return what came of it.

    Args:
        folder: For logs and configurations.
        count: Inputs.
        seed: Decides which.
        only: Part of the names of what is fuzzed; empty for all.
        tick_limit: [s] of wall time that no tick may take.
    """
    with reserved_domain() as domain:
        swarm = Swarm(folder, domain, ROBOTS, world={"speed": SPEED})
        try:
            swarm.wait_until_active()
            fuzzer = Fuzzer(swarm, seed, only, tick_limit)
            outcome = fuzzer.run(count)
        finally:
            swarm.close()
    verdict = folder / "verdict.json"
    if not outcome.problems and not verdict.is_file():
        outcome.problems.append("the world left no verdict")
    return outcome


def main() -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=100_000, help="inputs")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="targets with this in their name")
    parser.add_argument("--keep", type=Path, help="folder for the logs")
    parser.add_argument("--tick-limit", type=float, default=TICK_LIMIT, help="[s] of wall time")
    options = parser.parse_args()
    ros_env.set_defaults()  # no shared memory, as in the swarm
    warnings.filterwarnings("ignore", "overflow encountered", RuntimeWarning)  # of float32 fields
    folder = options.keep or Path(tempfile.mkdtemp(prefix="fuzz-"))
    folder.mkdir(parents=True, exist_ok=True)
    outcome = fuzz(folder, options.count, options.seed, options.only, options.tick_limit)
    figures = {
        "sent": sum(outcome.sent.values()),
        "targets": len(outcome.sent),
        "answered": outcome.answered,
        "unanswered": outcome.unanswered,
        "worst_tick_s": round(outcome.worst_tick, 3),
        "ticks_above_limit": outcome.slow_ticks,
        "ticks": outcome.ticks,
        "memory_mb": outcome.memory,
        "wall_time_s": round(outcome.wall_time, 1),
        "folder": str(folder),
    }
    sys.stdout.write(json.dumps(figures, indent=1) + "\n")
    for problem in outcome.problems:
        sys.stdout.write(f"{problem}\n")
    return 1 if outcome.problems else 0


if __name__ == "__main__":
    sys.exit(main())

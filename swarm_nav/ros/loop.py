"""The loop of a navigator process: it waits for ticks, and does everything else in between."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from rclpy.context import Context
from rclpy.executors import Executor, ExternalShutdownException

from swarm_common.middleware.graph_watch import GraphWatch
from swarm_common.middleware.ros_poll import Waiter, drain
from swarm_nav.ros.node import NavigatorNode

WAIT_SLICE = 0.25  # [s] the same while no tick can come; signals are looked at as well
REQUEST_PERIOD = 0.05  # [s] of wall time between two checks for requests and other work
BUSY_PERIOD = 0.2  # [s] the same while ticks come: a check costs a third as much as a tick
LARGE_PERIOD = 0.5  # [s] the same in a large swarm, whose ticks take long
BUSY_TIME = 1.0  # [s] without a tick after which the world is taken to be paused
PACK_SLICE = 0.01  # [s] while some navigators of the process wait for a tick and some do not


@dataclass(frozen=True, slots=True)
class Slot:
    """One navigator of a process."""

    name: str  # of the robot
    node: NavigatorNode
    # for all of this node that is not sensor data, so that a failure has one owner
    executor: Executor


class TickLoop:
    """The navigators of one process, turn after turn.

    Sensor data are waited for and taken directly (`ros_poll`): once per tick, where an executor
    would be woken for each message. Requests, goals and parameters come through the executors,
    which are emptied from time to time. While no tick can come, that is, before the map or while an
    answer is withheld until the next goal, the executor is what is waited for.
    """

    def __init__(self, slots: Sequence[Slot], context: Context) -> None:
        self._slots = list(slots)
        self._waiter = Waiter(context, len(slots))
        self._graph = GraphWatch(context)
        self._requests_due = 0.0
        self._request_period = REQUEST_PERIOD
        self._tick = 0
        self._tick_at = 0.0
        self._failures: list[tuple[Slot, Exception]] = []
        for slot in slots:
            slot.executor.add_node(slot.node.node)

    def turn(self) -> list[tuple[Slot, Exception]]:
        """Wait for something to do, and do it.

        Returns:
            Navigators that failed, and why; they have left the graph.

        Raises:
            Exception: Whatever the last navigator fails with.
        """
        self._wait()
        for slot in self._slots:
            self._try(slot, slot.node.receive_inputs)
        now = time.monotonic()
        if now >= self._requests_due:
            self._record_ticks(now)
            self._requests_due = now + self._request_period
            has_changed = self._graph.has_changed(self._slots[0].node.node)
            for slot in self._slots:
                self._try(slot, partial(drain, slot.executor))
                self._try(slot, partial(slot.node.look_around, now, has_changed))
        return self._dismiss()

    @property
    def ticked_at(self) -> float:
        """Wall time [s] of the last tick, as far as it has been noticed; 0 before the first."""
        return self._tick_at

    def end(self) -> None:
        """Send the reports that are still waiting."""
        for slot in self._slots:
            slot.node.rejections.flush()

    def _record_ticks(self, now: float) -> None:
        """Check for requests more often while no ticks come."""
        tick = self._slots[0].node.tick
        if tick != self._tick:
            self._tick, self._tick_at = tick, now
        is_busy = now - self._tick_at < BUSY_TIME
        busy_period = LARGE_PERIOD if self._slots[0].node.is_in_large_swarm else BUSY_PERIOD
        self._request_period = busy_period if is_busy else REQUEST_PERIOD

    def _wait(self) -> None:
        topics = []
        idle = []
        for slot in self._slots:
            if (topic := slot.node.awaited) is not None:
                topics.append(topic)
            else:
                idle.append(slot)
        if not idle:
            self._waiter.wait(topics, self._request_period)
            return
        first, *others = idle
        period = WAIT_SLICE if len(self._slots) == 1 else PACK_SLICE
        self._try(first, lambda: first.executor.spin_once(timeout_sec=period))
        for slot in others:
            self._try(slot, partial(drain, slot.executor))

    def _try(self, slot: Slot, work: Callable[[], object]) -> None:
        """Run the work of one navigator, so that its failure does not affect the others."""
        try:
            work()
        except ExternalShutdownException:
            raise
        except Exception as error:
            if len(self._slots) == 1:
                raise
            self._failures.append((slot, error))

    def _dismiss(self) -> list[tuple[Slot, Exception]]:
        """Remove failed navigators from the graph."""
        failures, self._failures = self._failures, []
        known: dict[str, tuple[Slot, Exception]] = {}
        for slot, error in failures:
            if slot.name not in known:
                known[slot.name] = slot, error
                self._slots.remove(slot)
                slot.executor.remove_node(slot.node.node)
                with contextlib.suppress(Exception):  # half of it may be gone
                    slot.node.destroy()
                slot.executor.shutdown()  # only this releases removed entities
        return list(known.values())

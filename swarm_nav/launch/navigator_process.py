"""Work of a navigator process: one navigator, or a pack of them."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException
from rclpy.signals import SignalHandlerOptions

from swarm_common.middleware.rclpy_compat import SafeExecutor
from swarm_common.process.lifetime import BEGINS_ANEW, LEASE, SleepWatch
from swarm_common.process.messages import NavigatorActive, NavigatorDied
from swarm_common.process.pipes import EventWriter
from swarm_nav.ros.loop import Slot, TickLoop
from swarm_nav.ros.node import NavigatorNode
from swarm_nav.ros.settings import NodeSettings

REUNION = 15.0  # [s] for ticks to come after the process was stopped,
QUEUED = 5.0  # [s] of which do not count: ticks of before were queued


def run_navigators(group: Sequence[NodeSettings], events: EventWriter) -> None:
    """Run the navigators of one process until SIGTERM.

    One that fails leaves the graph and is reported; the others go on. The failure of the last
    one is that of the process. A process that was stopped for so long that DDS has forgotten it,
    and gets no tick, ends with `BEGINS_ANEW`: links that one side has forgotten do not come back.

    Args:
        group: Settings of the robots of the process.

    Raises:
        Exception: Whatever the last navigator fails with.
    """
    is_stopped = False

    def stop(*_: object) -> None:
        nonlocal is_stopped
        is_stopped = True

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, stop)
    context = Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    loop = TickLoop([_slot(settings, context, events) for settings in group], context)
    watch = StopWatch()
    with contextlib.suppress(ExternalShutdownException):
        while not is_stopped:
            for slot, error in loop.turn():
                traceback.print_exception(error)
                events.write(NavigatorDied(slot.name, 1))
            if watch.is_forgotten(loop.ticked_at):
                sys.stderr.write("this process was stopped, and gets no ticks: it begins anew\n")
                sys.stderr.flush()
                os._exit(BEGINS_ANEW)
    loop.end()


class StopWatch:
    """Notices that the process was stopped, and that the world has forgotten it meanwhile."""

    def __init__(
        self, sleep: SleepWatch | None = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Start awake.

        Args:
            clock: Wall clock [s].
        """
        self._sleep = sleep or SleepWatch(LEASE)
        self._clock = clock
        self._woke_at: float | None = None

    def is_forgotten(self, ticked_at: float) -> bool:
        """Whether nothing but queued ticks has come for `REUNION` since the process was stopped.

        Args:
            ticked_at: Wall time [s] of the last tick.
        """
        if self._sleep.slept():
            self._woke_at = self._clock()
        if self._woke_at is None:
            return False
        if ticked_at > self._woke_at + QUEUED:
            self._woke_at = None
            return False
        return self._clock() - self._woke_at > REUNION


def _slot(settings: NodeSettings, context: Context, events: EventWriter) -> Slot:
    def tell() -> None:
        events.write(NavigatorActive(settings.name, os.getpid()))

    node = NavigatorNode(settings, context, tell, events)
    return Slot(settings.name, node, SafeExecutor(context=context))

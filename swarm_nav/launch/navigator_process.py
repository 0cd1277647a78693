"""What runs in a navigator process: one navigator, or a pack of them."""

from __future__ import annotations

import contextlib
import os
import signal
import traceback
from collections.abc import Sequence

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException
from rclpy.signals import SignalHandlerOptions

from swarm_common.middleware.rclpy_compat import SafeExecutor
from swarm_common.process.messages import NavigatorActive, NavigatorDied
from swarm_common.process.pipes import EventWriter
from swarm_nav.ros.loop import Slot, TickLoop
from swarm_nav.ros.node import NavigatorNode
from swarm_nav.ros.settings import NodeSettings


def run_navigators(group: Sequence[NodeSettings], events: EventWriter) -> None:
    """Run the navigators of one process until SIGTERM.

    One that fails leaves the graph and is reported; the others go on. The failure of the last
    one is that of the process.

    Args:
        group: Settings of the robots of the process.
        events: For swarm-up.

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
    with contextlib.suppress(ExternalShutdownException):
        while not is_stopped:
            for slot, error in loop.turn():
                traceback.print_exception(error)
                events.write(NavigatorDied(slot.name, 1))
    loop.end()


def _slot(settings: NodeSettings, context: Context, events: EventWriter) -> Slot:
    def tell() -> None:
        events.write(NavigatorActive(settings.name, os.getpid()))

    node = NavigatorNode(settings, context, tell, events)
    return Slot(settings.name, node, SafeExecutor(context=context))

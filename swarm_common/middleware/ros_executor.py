"""rclpy's EventsExecutor, but a task that fails does not end the process."""

from __future__ import annotations

import faulthandler
import inspect
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy

from swarm_common.process.last_resort import FaultLog


class SafeExecutor(_rclpy.EventsExecutor):  # type: ignore[misc]  # rclpy has no types
    """An EventsExecutor whose tasks never raise: what they raise goes to the log.

    rclpy 7.1 ends the process by SIGSEGV when a task raises and the executor has one node: it takes
    the first of a set of nodes by `nodes_[0]`, which in pybind11 is a null pointer to a name.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        """Begin without nodes; the rest is what rclpy.experimental does.

        Args:
            context: Of its nodes; None for the default one.
        """
        context = context or rclpy.get_default_context()
        faulthandler.enable()
        super().__init__(context)
        context.on_shutdown(self.wake)
        self._faults = FaultLog("task")

    def create_task(self, callback: Callable[..., Any], *args: Any, **options: Any) -> Any:
        """Schedule a function or a coroutine function; rclpy itself does so for what is done."""
        note = self._faults.note
        if inspect.iscoroutinefunction(callback):

            async def wait_for(*args: Any, **options: Any) -> Any:
                try:
                    return await callback(*args, **options)
                except Exception as error:
                    note(error)

            return super().create_task(wait_for, *args, **options)

        def call(*args: Any, **options: Any) -> Any:
            try:
                return callback(*args, **options)
            except Exception as error:
                note(error)

        return super().create_task(call, *args, **options)

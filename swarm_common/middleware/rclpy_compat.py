"""The private parts of rclpy that we use, all in one place; written for rclpy 7.1 (Jazzy).

rclpy has no public way to take a message without an executor, to go on after a task that raised, or
to answer parameter requests that make no sense.
"""

from __future__ import annotations

import faulthandler
import inspect
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.service import Service
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from rclpy.time_source import TimeSource
from rclpy.type_support import check_for_type_support

from swarm_common.process.private_parts import require
from swarm_common.process.standard_streams import FaultLog, shown

Describe = Callable[[ParameterDescriptor], ParameterDescriptor]
MOST = 1000  # parameters of a request
LONGEST = 256  # letters of a name
PARTS: tuple[tuple[Any, str], ...] = (
    (_rclpy, "EventsExecutor"),
    (_rclpy, "Node"),
    (_rclpy, "Service"),
    (_rclpy, "Subscription"),
    (_rclpy, "WaitSet"),
    (_rclpy.Node, "pointer"),
    (_rclpy.Subscription, "pointer"),
    (_rclpy.Subscription, "destroy_when_not_in_use"),
    (_rclpy.Service, "service_take_request"),
    (_rclpy.Service, "service_send_response"),
    (_rclpy.WaitSet, "add_subscription"),
    (_rclpy.WaitSet, "clear_entities"),
    (_rclpy.WaitSet, "is_ready"),
    (_rclpy.WaitSet, "pointer"),
    (_rclpy.WaitSet, "wait"),
    (Node.__init__, "_services"),
    (Node.__init__, "_time_source"),
    (Node, "_wake_executor"),
    (ParameterService, "_describe_parameters_callback"),
    (ParameterService, "_get_parameter_types_callback"),
    (ParameterService, "_get_parameters_callback"),
    (ParameterService, "_list_parameters_callback"),
    (ParameterService, "_set_parameters_atomically_callback"),
    (ParameterService, "_set_parameters_callback"),
    (TimeSource, "_subscribe_to_clock_topic"),
    (TimeSource, "clock_callback"),
)
require("ros-jazzy-rclpy", __name__, PARTS)


def join_graph(name: str, namespace: str | None = None) -> Node:
    """Return a bare node in the graph; signals are left to the process.

    rclpy's own handlers would take the graph down before the process has done what it has to.
    """
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    return rclpy.create_node(
        name, namespace=namespace, enable_rosout=False, start_parameter_services=False
    )


# Topics and services that no executor knows


def subscription(node: Node, kind: Any, name: str, quality: QoSProfile) -> Any:
    """Return the handle of a subscription; `pointer` is the address of its rcl_subscription_t."""
    check_for_type_support(kind)
    with node.handle:
        return _rclpy.Subscription(node.handle, kind, name, quality.get_c_qos_profile())


def service(node: Node, kind: Any, name: str) -> Any:
    """Return the handle of a service."""
    check_for_type_support(kind)
    quality = qos_profile_services_default.get_c_qos_profile()
    with node.handle:
        return _rclpy.Service(node.handle, kind, name, quality)


def name_in_graph(node: Node, name: str) -> Any:
    """Return the handle of a node that has only a name, beside another one in its namespace."""
    context = node.context.handle
    with context:
        return _rclpy.Node(name, node.get_namespace(), context, None, False, False)


def service_of_name(
    node: Node, owner: Any, kind: Any, name: str, answer: Callable[[Any, Any], Any]
) -> None:
    """Offer a service of a node that exists in name only; a real node's executor answers.

    Args:
        owner: Result of `name_in_graph`.
        answer: Gets request and response, returns the response.
    """
    check_for_type_support(kind)
    quality = qos_profile_services_default
    with owner:
        handle = _rclpy.Service(owner, kind, name, quality.get_c_qos_profile())
    group = node.default_callback_group
    wrapped = Service(handle, kind, name, answer, group, quality)
    group.add_entity(wrapped)
    node._services.append(wrapped)
    node._wake_executor()


def removable_publisher(node: Node, kind: Any, name: str, quality: QoSProfile) -> Publisher:
    """Return a publisher that may be destroyed while a SafeExecutor has its node.

    It does not report subscribers of another quality or type. rclpy 7.1 ends the process by SIGSEGV
    when such an event comes between the end of a publisher and the executor's next turn: it drops
    its last reference to the wait set of the event's handler without holding Python's lock.
    """
    silent = PublisherEventCallbacks(use_default_callbacks=False)
    return node.create_publisher(kind, name, quality, event_callbacks=silent)


def removable_subscription(
    node: Node, kind: Any, name: str, callback: Callable[[Any], object], quality: QoSProfile
) -> Subscription:
    """Return a subscription that may be destroyed while a SafeExecutor has its node."""
    silent = SubscriptionEventCallbacks(use_default_callbacks=False)
    return node.create_subscription(kind, name, callback, quality, event_callbacks=silent)


def wait_set(context: Context, subscriptions: int = 0, guards: int = 0) -> Any:
    """Return a wait set for a number of subscriptions and guard conditions."""
    with context.handle:
        return _rclpy.WaitSet(subscriptions, guards, 0, 0, 0, 0, context.handle)


class SafeExecutor(_rclpy.EventsExecutor):  # type: ignore[misc]  # rclpy has no types
    """An EventsExecutor whose tasks never raise: their exceptions go to the log.

    rclpy 7.1 ends the process by SIGSEGV when a task raises and the executor has one node: it takes
    the first of a set of nodes by `nodes_[0]`, which in pybind11 is a null pointer to a name.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        """Begin without nodes; the rest is what rclpy.experimental does."""
        context = context or rclpy.get_default_context()
        faulthandler.enable()
        super().__init__(context)
        context.on_shutdown(self.wake)
        self._faults = FaultLog("task")

    def create_task(self, callback: Callable[..., Any], *args: Any, **options: Any) -> Any:
        """Schedule a function or a coroutine function; rclpy does so for completed futures.

        Args:
            callback: The function; what it raises is logged.
        """
        note = self._faults.note
        if inspect.iscoroutinefunction(callback):

            async def wait_for(*args: Any, **options: Any) -> Any:
                """Await the callback, and log what it raises."""
                try:
                    return await callback(*args, **options)
                except Exception as error:
                    note(error)

            return super().create_task(wait_for, *args, **options)

        def call(*args: Any, **options: Any) -> Any:
            """Call the callback, and log what it raises."""
            try:
                return callback(*args, **options)
            except Exception as error:
                note(error)

        return super().create_task(call, *args, **options)


class CheckedParameterService(ParameterService):  # type: ignore[misc]  # rclpy has no types
    """The six parameter services of a node that was created without them.

    rclpy's own services raise an error at unknown types, which ends the process. These answer every
    request.
    """

    def __init__(self, node: Node, describe: Describe = lambda found: found) -> None:
        """Offer them.

        Args:
            describe: Adds to rclpy's descriptions of parameters what clients ask for. A range that
                rclpy knew would be checked by rclpy, with another message than ours.
        """
        self._node = node
        self._describe = describe
        super().__init__(node)

    def _describe_parameters_callback(self, request: Any, response: Any) -> Any:
        if _are_known(request.names):
            response = super()._describe_parameters_callback(request, response)
            response.descriptors = [self._describe(found) for found in response.descriptors]
        return response

    def _get_parameters_callback(self, request: Any, response: Any) -> Any:
        known = _are_known(request.names)
        return super()._get_parameters_callback(request, response) if known else response

    def _get_parameter_types_callback(self, request: Any, response: Any) -> Any:
        known = _are_known(request.names)
        return super()._get_parameter_types_callback(request, response) if known else response

    def _list_parameters_callback(self, request: Any, response: Any) -> Any:
        known = _are_known(request.prefixes)
        return super()._list_parameters_callback(request, response) if known else response

    def _set_parameters_callback(self, request: Any, response: Any) -> Any:
        for message in request.parameters[:MOST]:
            response.results.append(self._set([message]))
        return response

    def _set_parameters_atomically_callback(self, request: Any, response: Any) -> Any:
        response.result = self._set(request.parameters)
        return response

    def _set(self, messages: Sequence[Any]) -> SetParametersResult:
        if not _are_known([message.name for message in messages]):
            reason = f"at most {MOST} names of at most {LONGEST} letters are read"
            return SetParametersResult(successful=False, reason=reason)
        try:
            parameters = [Parameter.from_parameter_msg(message) for message in messages]
            return self._node.set_parameters_atomically(parameters)
        except Exception as error:  # of rclpy: types, names and values that it does not take
            reason = shown(str(error) or type(error).__name__)
            return SetParametersResult(successful=False, reason=reason)


def _are_known(names: Sequence[str]) -> bool:
    """Report whether names may be those of parameters at all."""
    return len(names) <= MOST and all(len(name) <= LONGEST for name in names)


def time_source_without_topic(node: Node) -> TimeSource:
    """Return the time source of a node, which will not subscribe to /clock.

    rclpy offers no other way to have `use_sim_time` without the subscription.

    Args:
        node: A node without `use_sim_time`.
    """
    source = node._time_source
    source._subscribe_to_clock_topic = lambda: None
    return source

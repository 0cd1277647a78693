"""A node's parameter services, which answer whatever is asked.

Those of rclpy raise at types that there are not, which ends the process.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService

from swarm_common.process.last_resort import shown

MOST = 1000  # parameters of a request
LONGEST = 256  # letters of a name


class CheckedParameterService(ParameterService):  # type: ignore[misc]  # rclpy has no types
    """The six services of a node that was created without them."""

    def __init__(self, node: Node) -> None:
        """Offer them."""
        self._node = node
        super().__init__(node)

    def _describe_parameters_callback(self, request: Any, response: Any) -> Any:
        known = _are_known(request.names)
        return super()._describe_parameters_callback(request, response) if known else response

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
    """Whether names may be those of parameters at all."""
    return len(names) <= MOST and all(len(name) <= LONGEST for name in names)

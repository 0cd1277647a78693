"""The ROS parameters of a navigator: the brain's can be set while it runs, the others not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from swarm_common.middleware.rclpy_compat import CheckedParameterService
from swarm_common.middleware.rejections import Rejections
from swarm_common.model.errors import SwarmError
from swarm_common.model.records import RobotSpec
from swarm_common.model.robot_parameters import robot_parameters
from swarm_nav.core.config import (
    FIXED_PARAMETERS,
    NavConfig,
    config_from_parameters,
    parameter_values,
)
from swarm_nav.core.parameter_table import parameter_table
from swarm_nav.ros.nav2.demand import OnDemand
from swarm_nav.ros.settings import (
    FIXED_EFFECTS,
    LIMITED,
    ROBOT_PREFIX,
    USE_SIM_TIME,
    NodeSettings,
    check_limits,
)

SERVICES = (
    "describe_parameters",
    "get_parameter_types",
    "get_parameters",
    "list_parameters",
    "set_parameters",
    "set_parameters_atomically",
)


class Parameters:
    """Declares the parameters and passes changes on.

    Attributes:
        config: The brain's parameters in force.
    """

    def __init__(
        self,
        node: Node,
        settings: NodeSettings,
        on_change: Callable[[NavConfig], None],
        on_demand: OnDemand,
        rejections: Rejections,
    ) -> None:
        """Declare everything."""
        self.config = settings.config
        self._spec = settings.spec
        self._on_change = on_change
        self._rejections = rejections
        self._names = frozenset(parameter_values(settings.config))
        fixed = {name: value for name, value in settings.fixed.items() if name != USE_SIM_TIME}
        for name, value in robot_parameters(settings.spec).items():
            fixed[ROBOT_PREFIX + name] = value
        changeable = [
            (name, value, ParameterDescriptor(read_only=name in FIXED_PARAMETERS))
            for name, value in parameter_values(settings.config).items()
        ]
        constant = [
            (name, value, ParameterDescriptor(read_only=True)) for name, value in fixed.items()
        ]
        node.declare_parameters("", changeable + constant, ignore_override=True)
        node.add_on_set_parameters_callback(self._on_set)
        services = [f"{node.get_name()}/{service}" for service in SERVICES]
        on_demand.offer(services, lambda: CheckedParameterService(node, self._describe))

    def _describe(self, found: ParameterDescriptor) -> ParameterDescriptor:
        return describe(found, self._spec)

    def _on_set(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        values: dict[str, Any] = {
            parameter.name: parameter.value
            for parameter in parameters
            if parameter.name in self._names
        }
        try:
            config = config_from_parameters(values, self.config)
            check_limits(config, self._spec)
        except SwarmError as error:
            self._rejections.reject("parameter", "a client", error)
            return SetParametersResult(successful=False, reason=str(error))
        if config != self.config:
            self.config = config
            self._on_change(config)
        return SetParametersResult(successful=True)


def describe(found: ParameterDescriptor, spec: RobotSpec) -> ParameterDescriptor:
    """Return the description of a parameter, besides its name and type.

    Args:
        spec: Description of the robot, whose limits are those of its controller.
    """
    told = ParameterDescriptor(
        name=found.name,
        type=found.type,
        read_only=found.read_only,
        dynamic_typing=found.dynamic_typing,
    )
    row = parameter_table().get(found.name)
    if row is None:
        robot = "of the robot model" if found.name.startswith(ROBOT_PREFIX) else ""
        told.description = FIXED_EFFECTS.get(found.name, robot)
        return told
    told.description = row.description
    told.additional_constraints = row.constraint
    high = getattr(spec, row.name) if row.name in LIMITED else row.high
    if isinstance(row.default, float):
        limits = FloatingPointRange(from_value=float(row.low), to_value=float(high))
        told.floating_point_range = [limits]
    elif row.is_number:
        told.integer_range = [IntegerRange(from_value=int(row.low), to_value=int(high))]
    return told

"""Pause, step and speed of the world: simulation_interfaces' services and a parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import GetSimulationState, SetSimulationState, StepSimulation

from swarm_common.middleware.rclpy_compat import CheckedParameterService
from swarm_common.middleware.ros_poll import PolledService
from swarm_common.middleware.tick_action import GoalHandle, TickActionServer
from swarm_sim.ros.services.run_state import MOST_STEPS, Answer, RunState

SPEED = "speed"
NOT_NOW = f"pause first; steps are 1 to {MOST_STEPS}, all that are under way included"
SLOWEST, FASTEST = 0.001, 1000.0  # [times real time]
STATES = {SimulationState.STATE_STOPPED: "stopped", SimulationState.STATE_QUITTING: "quitting"}


class Control:
    """`/sim/get_simulation_state`, `set_simulation_state`, `step_simulation`, `simulate_steps`.

    A step is a control tick. The parameter `speed` of the node `/sim/world` is in times real
    time; 0 is as fast as possible.
    """

    def __init__(
        self,
        node: Node,
        state: RunState,
        speed: float | None,
        on_speed: Callable[[float | None], None],
    ) -> None:
        """Create services and parameter.

        Args:
            speed: At the start, None for no limit.
        """
        self._state = state
        self._on_speed = on_speed
        self._is_cancelled = False
        make = node.create_service
        make(GetSimulationState, "/sim/get_simulation_state", self._get)
        make(SetSimulationState, "/sim/set_simulation_state", self._set)
        self._steps = PolledService(node, StepSimulation, "/sim/step_simulation")
        TickActionServer(
            node,
            SimulateSteps,
            "/sim/simulate_steps",
            lambda _: True,
            self._simulate_steps,
            lambda _: setattr(self, "_is_cancelled", True),
        )
        node.declare_parameter(
            SPEED,
            0.0 if speed is None else speed,
            ParameterDescriptor(
                description="times real time; 0: as fast as possible",
                additional_constraints=f"0, or {SLOWEST:g} to {FASTEST:g}",
            ),
        )
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._apply)
        CheckedParameterService(node)

    def destroy(self) -> None:
        """Withdraw what the node does not destroy itself."""
        self._steps.destroy()

    def _get(self, _: Any, response: Any) -> Any:
        paused = self._state.is_paused
        response.state.state = (
            SimulationState.STATE_PAUSED if paused else SimulationState.STATE_PLAYING
        )
        response.result.result = Result.RESULT_OK
        return response

    def _set(self, request: Any, response: Any) -> Any:
        target = request.state.state
        if target == SimulationState.STATE_PAUSED:
            answer = self._state.pause()
        elif target == SimulationState.STATE_PLAYING:
            answer = self._state.play()
        else:
            name = STATES.get(target, f"state {target}")
            response.result.result = Result.RESULT_FEATURE_UNSUPPORTED
            response.result.error_message = f"{name} is not supported; expected playing or paused"
            return response
        is_new = answer is Answer.DONE
        response.result.result = (
            Result.RESULT_OK if is_new else SetSimulationState.Response.ALREADY_IN_TARGET_STATE
        )
        return response

    def poll_steps(self) -> None:
        """Receive requests for steps; they are answered when the steps are done."""
        if self._is_cancelled:
            self._is_cancelled = False
            self._state.cancel_steps()
        while (taken := self._steps.take()) is not None:
            request, request_id = taken
            response = StepSimulation.Response()

            def end(are_done: bool, response: Any = response, request_id: Any = request_id) -> None:
                """Answer a request.

                Args:
                    are_done: Whether its steps are done; else they were cancelled.
                    response: Response to this request, not to the loop's last one.
                """
                _fill(response.result, are_done, "the steps were cancelled")
                self._steps.answer(response, request_id)

            if self._state.step(request.steps, end) is Answer.REFUSED:
                _fill(response.result, False, NOT_NOW)
                self._steps.answer(response, request_id)

    def _simulate_steps(self, server: TickActionServer, handle: GoalHandle) -> None:
        """Begin the steps of an action."""
        wanted = int(handle.request.steps)
        feedback = SimulateSteps.Feedback(remaining_steps=wanted)

        def record_tick() -> None:
            if feedback.remaining_steps:
                feedback.completed_steps += 1
                feedback.remaining_steps -= 1
                server.publish_feedback(handle, feedback)

        def end(are_done: bool, reason: str = "the steps were cancelled") -> None:
            """End the action."""
            result = SimulateSteps.Result()
            _fill(result.result, are_done, reason)
            server.finish(handle, result, succeeded=are_done)

        if self._state.step(wanted, end, record_tick) is Answer.REFUSED:
            end(False, NOT_NOW)

    @staticmethod
    def _check(parameters: Sequence[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            value = parameter.value
            if parameter.name != SPEED:
                continue
            if not isinstance(value, float) or not is_speed(value):
                reason = (
                    f"speed is {value}; expected {SLOWEST:g} to {FASTEST:g} in times real time, or "
                    "0: no limit"
                )
                return SetParametersResult(successful=False, reason=reason)
        return SetParametersResult(successful=True)

    def _apply(self, parameters: Sequence[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == SPEED:
                self._on_speed(float(parameter.value) or None)


def _fill(result: Result, is_done: bool, reason: str) -> None:
    """Fill in how a request ended; `reason` is for one that was not done."""
    result.result = Result.RESULT_OK if is_done else Result.RESULT_OPERATION_FAILED
    result.error_message = "" if is_done else reason


def is_speed(value: float) -> bool:
    """Whether a speed can be kept to; 0 stands for no limit."""
    return value == 0.0 or SLOWEST <= value <= FASTEST

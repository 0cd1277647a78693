"""Nav2's nodes as the graph shows them: names with lifecycle services, in one process and state.

A robot is one node, `navigator`. Lifecycle tools look for Nav2's: so there are nodes of these
names, which have nothing but their lifecycle services; all of them show and change the one state.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from lifecycle_msgs.msg import State, Transition, TransitionDescription
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from rclpy.node import Node

from swarm_common.middleware.rclpy_compat import name_in_graph, service_of_name
from swarm_nav.core.lifecycle import Lifecycle
from swarm_nav.ros.nav2.demand import OnDemand

NODES = (
    "amcl", "behavior_server", "bt_navigator", "controller_server", "map_server", "planner_server"
)  # fmt: skip
PRIMARY = {
    State.PRIMARY_STATE_UNKNOWN: "unknown",
    State.PRIMARY_STATE_UNCONFIGURED: "unconfigured",
    State.PRIMARY_STATE_INACTIVE: "inactive",
    State.PRIMARY_STATE_ACTIVE: "active",
    State.PRIMARY_STATE_FINALIZED: "finalized",
}
PASSING = {
    State.TRANSITION_STATE_CONFIGURING: "configuring",
    State.TRANSITION_STATE_CLEANINGUP: "cleaningup",
    State.TRANSITION_STATE_SHUTTINGDOWN: "shuttingdown",
    State.TRANSITION_STATE_ACTIVATING: "activating",
    State.TRANSITION_STATE_DEACTIVATING: "deactivating",
    State.TRANSITION_STATE_ERRORPROCESSING: "errorprocessing",
}
IDS = {label: number for number, label in (*PRIMARY.items(), *PASSING.items())}
# Id, label, state that it leads from, state that it passes through, command of ours.
TRANSITIONS = (
    (Transition.TRANSITION_CONFIGURE, "configure", "unconfigured", "configuring", "configure"),
    (Transition.TRANSITION_CLEANUP, "cleanup", "inactive", "cleaningup", "cleanup"),
    (Transition.TRANSITION_ACTIVATE, "activate", "inactive", "activating", "resume"),
    (Transition.TRANSITION_DEACTIVATE, "deactivate", "active", "deactivating", "pause"),
    (Transition.TRANSITION_UNCONFIGURED_SHUTDOWN, "shutdown", "unconfigured", "shuttingdown",
     "shutdown"),
    (Transition.TRANSITION_INACTIVE_SHUTDOWN, "shutdown", "inactive", "shuttingdown", "shutdown"),
    (Transition.TRANSITION_ACTIVE_SHUTDOWN, "shutdown", "active", "shuttingdown", "shutdown"),
)  # fmt: skip


class LifecycleServices:
    """The lifecycle services under each of Nav2's node names."""

    def __init__(
        self, node: Node, lifecycle: Lifecycle, change: Callable[[str], bool], on_demand: OnDemand
    ) -> None:
        """Offer them: `get_state` as other servers, the rest only to clients."""
        self._node, self._lifecycle, self._change = node, lifecycle, change
        self._handles: dict[str, Any] = {}
        answers = {
            GetState: ("get_state", self._get_state),
            ChangeState: ("change_state", self._change_state),
            GetAvailableStates: ("get_available_states", self._list_states),
            GetAvailableTransitions: ("get_available_transitions", self._list_transitions),
        }
        for owner in NODES:
            for kind, (name, answer) in answers.items():
                serve = partial(self._serve, owner, kind, f"{owner}/{name}", answer)
                on_demand.offer([f"{owner}/{name}"], serve, is_rare=kind is not GetState)
            graph, answer = f"{owner}/get_transition_graph", self._list_all_transitions
            serve = partial(self._serve, owner, GetAvailableTransitions, graph, answer)
            on_demand.offer([graph], serve, is_rare=True)

    def destroy(self) -> None:
        """Leave the graph."""
        for handle in self._handles.values():
            handle.destroy_when_not_in_use()

    def _serve(self, owner: str, kind: Any, name: str, answer: Callable[[Any, Any], Any]) -> None:
        """Create a service of a node that has only a name, for the executor of the real one."""
        if owner not in self._handles:
            self._handles[owner] = name_in_graph(self._node, owner)
        service_of_name(self._node, self._handles[owner], kind, name, answer)

    def _get_state(self, _: Any, response: Any) -> Any:
        response.current_state = _state(self._lifecycle.state)
        return response

    def _change_state(self, request: Any, response: Any) -> Any:
        wanted = request.transition
        for number, label, start, _, command in TRANSITIONS:
            is_meant = label == wanted.label if wanted.label else number == wanted.id
            if is_meant and start == self._lifecycle.state:
                response.success = self._change(command)
        return response

    @staticmethod
    def _list_states(_: Any, response: Any) -> Any:
        response.available_states = [_state(label) for label in IDS]
        return response

    def _list_transitions(self, _: Any, response: Any) -> Any:
        response.available_transitions = _descriptions(self._lifecycle.state)
        return response

    @staticmethod
    def _list_all_transitions(_: Any, response: Any) -> Any:
        response.available_transitions = _descriptions(None)
        return response


def _state(label: str) -> State:
    return State(id=IDS[label], label=label)


def _descriptions(state: str | None) -> list[TransitionDescription]:
    """Return the transitions from a state, or all."""
    return [
        TransitionDescription(
            transition=Transition(id=number, label=label),
            start_state=_state(start),
            goal_state=_state(goal),
        )
        for number, label, start, goal, _ in TRANSITIONS
        if state in (None, start)
    ]

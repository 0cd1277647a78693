"""Plug-ins of a navigator: their parameters, entry points, and the built-in ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from swarm_common.model.errors import ConfigError
from swarm_common.process.plugins import Guard, PluginFault, load_plugin
from swarm_nav.core.config import NavConfig, parameter_values
from swarm_nav.core.goals import ErrorCode
from swarm_nav.core.localisation_config import AMCL

# Nav2's codes of goals that end because a plug-in failed.
CONTROL_CODES = {
    PluginFault.RAISED: ErrorCode.CONTROL_UNKNOWN,
    PluginFault.LATE: ErrorCode.CONTROLLER_TIMED_OUT,
    PluginFault.UNUSABLE: ErrorCode.NO_VALID_CONTROL,
}
PLAN_CODES = {
    PluginFault.RAISED: ErrorCode.PLAN_UNKNOWN,
    PluginFault.LATE: ErrorCode.PLAN_TIMEOUT,
    PluginFault.UNUSABLE: ErrorCode.NO_VALID_PATH,
}
LOCALISER_CODES = dict.fromkeys(PluginFault, ErrorCode.PLAN_TF_ERROR)
Report = Callable[[ErrorCode, str], None]  # takes a fault: its code and a message


def ignore(code: ErrorCode, message: str) -> None:
    """Ignore a fault that nobody waits for; it was printed."""


@dataclass(frozen=True, slots=True)
class PluginKind:
    """One part of a robot that can be replaced."""

    word: str  # for messages
    parameter: str
    group: str  # of entry points
    built_in: Mapping[str, str]  # module:Class by name
    codes: Mapping[PluginFault, ErrorCode]  # with which goals end
    method: str  # that it has in any case

    def is_own(self, name: str) -> bool:
        """Whether a name is not that of a built-in one."""
        return name not in self.built_in

    def guard(self, name: str, *arguments: Any) -> Guard:
        """Return a plug-in that was made from the arguments of its constructor.

        Raises:
            ConfigError: If there is none of this name.
        """
        return Guard(f"{self.word} {name}", self.load(name), *arguments)

    def load(self, name: str) -> Callable[..., Any]:
        """Return the class of a name.

        Raises:
            ConfigError: If there is none, or it is none for this part.
        """
        made = load_plugin(self.group, name, self.built_in, self.parameter)
        lacks = not any(hasattr(made, found) for found in (self.method, "__getattr__"))
        if isinstance(made, type) and lacks:
            raise ConfigError(
                f"{self.parameter} is '{name}', which has no {self.method}; see python -m pydoc"
                " swarm_nav.interfaces"
            )
        return made


CONTROLLER = PluginKind(
    "controller", "controller.plugin", "controllers",
    {"dwb": "swarm_nav.control.omni:make_controller"}, CONTROL_CODES, "follow",
)  # fmt: skip
PLANNER = PluginKind(
    "planner", "planner.plugin", "planners",
    {"astar": "swarm_nav.planning.planner:Planner"}, PLAN_CODES, "plan",
)  # fmt: skip
LOCALISER = PluginKind(
    "localiser", "localiser.plugin", "localisers",
    {"by_type": "swarm_nav.localisation.localiser:make_localiser"}, LOCALISER_CODES, "on_odom",
)  # fmt: skip
PRIORITY = PluginKind(
    "priority", "traffic.priority_plugin", "priorities",
    {"oldest_goal": "swarm_nav.core.rank:base_priority"}, CONTROL_CODES, "seniority",
)  # fmt: skip
RULE_NAMES = (  # built-in rules by precedence: safety, making way, admission, the way to the goal
    "keep_apart", "stop_before_obstacle", "plan_anew", "make_way", "leave", "behave", "arrive",
    "wait", "drive", "check_progress",
)  # fmt: skip
RULE = PluginKind(
    "rule", "traffic.rules", "rules",
    dict.fromkeys(RULE_NAMES, "swarm_nav.behaviour.rules:RULES"), CONTROL_CODES, "propose",
)  # fmt: skip
BRAIN = PluginKind(
    "brain", "brain.plugin", "brains",
    {
        "navigator": "swarm_nav.behaviour.navigator:Navigator",
        ".onnx": "swarm_workbench.policy:PolicyBrain",
    },
    CONTROL_CODES, "tick",
)  # fmt: skip
KINDS = (CONTROLLER, PLANNER, LOCALISER, PRIORITY, BRAIN)


def check_plugins(config: NavConfig) -> None:
    """Find the plug-ins of a robot, import their modules, and ask those that want to be asked.

    Raises:
        ConfigError: If one is missing, or its static method `check_config` refuses the parameters.
    """
    for parameter, name in own_plugins(config):
        check = getattr(_found(parameter, name), "check_config", None)
        if check is not None:
            check(config)


def own_plugins(config: NavConfig) -> list[tuple[str, str]]:
    """Return the parameter and the name of each plug-in of a robot that is not a built-in one."""
    values = parameter_values(config)
    named = [(kind, values[kind.parameter]) for kind in KINDS]
    named += [(RULE, name) for name in rule_names(config.traffic.rules)]
    return [(kind.parameter, name) for kind, name in named if kind.is_own(name)]


def rule_names(rules: str) -> tuple[str, ...]:
    """Return the names that `traffic.rules` lists, separated by blanks or commas."""
    return RULE_NAMES if rules == "all" else tuple(rules.replace(",", " ").split())


@cache  # once per process, before it forks
def _found(parameter: str, name: str) -> Callable[..., Any]:
    (kind,) = (kind for kind in (*KINDS, RULE) if kind.parameter == parameter)
    return kind.load(name)


def corrects_pose(config: NavConfig) -> bool:
    """Whether a robot's pose is corrected while it drives, so that it may jump."""
    return config.localisation.type == AMCL or LOCALISER.is_own(config.localiser.plugin)

"""The options of swarm-up as arguments of a ROS 2 launch file: names, help, and back to options."""

from __future__ import annotations

import difflib
import functools
from collections.abc import Iterable, Mapping
from typing import Any

from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_run.flags import parser

COMPLETION = ("--install-completion", "--show-completion")
NEAR = 0.75  # likeness from which a name is taken for a misspelt one


@functools.cache
def _options() -> dict[str, Any]:
    """Return the options of swarm-up by name of the launch argument, like `swarm_size`."""
    return {
        item.opts[0].lstrip("-").replace("-", "_"): item
        for item in parser().params
        if item.param_type_name == "option" and item.opts[0] not in COMPLETION
    }


def launch_arguments() -> dict[str, str]:
    """Return the names of all launch arguments with their help."""
    return {name: item.help or "" for name, item in _options().items()}


def check_arguments(words: Iterable[str]) -> None:
    """Refuse what is no launch argument of ours.

    Args:
        words: `name:=value`, as typed.

    Raises:
        UnknownNameError: Naming the first one.
    """
    for word in words:
        name, sign, _ = word.partition(":=")
        if sign and name not in _options():
            raise UnknownNameError("launch argument", name, _options())


def misspelt(names: Iterable[str]) -> list[str]:
    """Return a sentence on each name that is nearly one of ours.

    Args:
        names: Names of launch configurations, among them some that others have declared.
    """
    found = []
    for name in names:
        near = difflib.get_close_matches(name, _options(), n=1, cutoff=NEAR)
        if near and name not in _options():
            found.append(f"'{name}' is no argument of swarm.launch.py; did you mean '{near[0]}'?")
    return found


def options_of(given: Mapping[str, str]) -> list[str]:
    """Return the options of swarm-up that launch arguments mean.

    Args:
        given: Values by name; empty ones are not given, other names are left out.

    Raises:
        ConfigError: If a flag is neither true nor false.
    """
    options: list[str] = []
    for name, item in _options().items():
        value = given.get(name, "")
        if value and item.is_flag:
            if value.lower() not in ("true", "false"):
                raise ConfigError(f"launch argument {name} is '{value}'; expected true or false")
            options += item.opts[:1] if value.lower() == "true" else item.secondary_opts[:1]
        elif value:
            options += [item.opts[0], value]
    return options

"""Unit, effect and range of each parameter of a navigator; from the comments of its class.

The one source of `ros2 param describe`, of docs/reference/parameters.md and of
params/navigator.yaml.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

from swarm_nav.core.config import FIXED_PARAMETERS, NavConfig
from swarm_nav.core.limits import ANY, CHOICES, RANGES, parameter_name

Value = bool | int | float | str


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """One parameter."""

    name: str  # of the ROS parameter
    group: str  # field of NavConfig that it belongs to
    default: Value  # its type is the parameter's
    unit: str  # like `m/s`; empty for counts, shares and names
    effect: str  # in a few words
    low: float  # least value of a number
    high: float  # largest value of a number
    excludes_low: bool  # whether `low` itself is refused
    excludes_high: bool  # whether `high` itself is refused
    choices: tuple[str, ...] = ()  # of a text
    is_fixed: bool = False  # whether it is read once, at the start

    @property
    def is_number(self) -> bool:
        """Whether it has a range."""
        return not isinstance(self.default, (bool, str))

    @property
    def description(self) -> str:
        """Effect and unit in one line."""
        return f"{self.effect} [{self.unit}]" if self.unit else self.effect

    @property
    def constraint(self) -> str:
        """The rule that a closed range cannot express; empty if there is none."""
        parts = [f"more than {self.low:.10g}"] * self.excludes_low
        parts += [f"less than {self.high:.10g}"] * self.excludes_high
        parts += [f"one of {', '.join(self.choices)}"] * bool(self.choices)
        return ", ".join(parts)


@cache
def parameter_table() -> dict[str, ParameterRow]:
    """Return all parameters by name, in the order of their classes."""
    config = NavConfig()
    rows = {}
    for group in dataclasses.fields(config):
        part = getattr(config, group.name)
        comments = field_comments(type(part))
        for item in dataclasses.fields(part):
            row = _row(group.name, part, item.name, comments.get(item.name, ""))
            rows[row.name] = row
    return rows


def field_comments(config_class: type) -> dict[str, str]:
    """Return the comment at the end of each field's line in the source of a class.

    Args:
        config_class: Dataclass at the top level of a module, with one field per line.

    Returns:
        Comments by name of the field; fields without one are missing.
    """
    source = inspect.getsource(sys.modules[config_class.__module__])
    head = rf"^class {config_class.__name__}\b.*:\n"
    rest = re.split(head, source, maxsplit=1, flags=re.MULTILINE)[1]
    body = re.split(r"^(?=\S)", rest, maxsplit=1, flags=re.MULTILINE)[0]
    pattern = r"^    (\w+): [^=#\n]+(?: = [^#\n]*)?  # ?(.*)$"
    return dict(re.findall(pattern, body, re.MULTILINE))


def unit_and_effect(comment: str) -> tuple[str, str]:
    """Return unit and effect from a comment like `[m/s] largest speed`.

    Args:
        comment: Behind a field, without the `#`.

    Returns:
        (unit, effect); the unit is empty if the comment does not begin with one in brackets.
    """
    match = re.match(r"\[([^\]]*)\]\s*(.*)", comment)
    return (match[1], match[2]) if match else ("", comment)


def _row(group: str, part: Any, field: str, comment: str) -> ParameterRow:
    name = parameter_name(group, field)
    default = getattr(part, field)
    unit, effect = unit_and_effect(comment)
    return ParameterRow(
        name,
        group,
        default,
        unit,
        effect,
        *RANGES.get(name, ANY),
        choices=CHOICES.get(name, ()),
        is_fixed=name in FIXED_PARAMETERS,
    )

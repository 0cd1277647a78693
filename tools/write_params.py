"""Writes params/navigator.yaml from the defaults in swarm_nav/core/config.py, with their comments.

A default has one home, the configuration class; the file is what users read and copy from, and
what `swarm-up` checks their parameters against. A test compares the two.
"""

from __future__ import annotations

import dataclasses
import inspect
import json
from pathlib import Path
from typing import Any

from swarm_nav.core.config import NavConfig
from swarm_nav.core.limits import parameter_name
from swarm_nav.core.parameter_table import field_comments

TARGET = Path(__file__).resolve().parent.parent / "params" / "navigator.yaml"
HEAD = """\
# Parameters of a navigator with their defaults, in ROS 2's form; written by tools/write_params.py.
# To change some: copy those lines into a file of your own and start with --params FILE. Instead of
# /** (all robots) a section may name one: /Srobot3/navigator. Speed and acceleration limits follow
# the robot model unless your file sets them.
/**:
  ros__parameters:
"""


def parameter_file() -> str:
    """Return the text of params/navigator.yaml."""
    lines = [HEAD]
    config = NavConfig()
    for group in dataclasses.fields(config):
        part = getattr(config, group.name)
        lines.append(f"    # {(inspect.getdoc(type(part)) or '').splitlines()[0]}\n")
        is_open = False
        comments = field_comments(type(part))
        for field in dataclasses.fields(part):
            is_bare = parameter_name(group.name, field.name) == field.name
            if not is_bare and not is_open:
                is_open = True
                lines.append(f"    {group.name}:\n")
            indent = " " * (4 if is_bare else 6)
            comment = f"  # {comments[field.name]}" if comments.get(field.name) else ""
            lines.append(f"{indent}{field.name}: {_yaml(getattr(part, field.name))}{comment}\n")
    return "".join(lines)


def _yaml(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


if __name__ == "__main__":
    TARGET.write_text(parameter_file(), encoding="utf-8")

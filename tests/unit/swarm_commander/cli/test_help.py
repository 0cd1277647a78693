"""Every --help has examples, and groups where it has many options."""

from typing import Any

import pytest
from typer.main import get_command

from tools.write_reference import APPS, COMPLETION

FEW = 10  # options that need no groups


def _commands():
    for name, load in APPS.items():
        command: Any = get_command(load())
        if name != "swarm-commander ":  # its commands are those of swarm-commander
            yield name, command
        yield from ((f"{name} {sub}", one) for sub, one in getattr(command, "commands", {}).items())


@pytest.mark.parametrize(("name", "command"), list(_commands()))
def test_help_has_examples_and_groups(name, command):
    assert "Example" in (command.epilog or ""), name
    shown = [one for one in command.params if one.name not in COMPLETION and not one.hidden]
    panels = {getattr(one, "rich_help_panel", None) for one in shown}
    assert len(shown) <= FEW or len(panels) > 1, name

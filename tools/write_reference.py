"""Writes docs/reference/: commands from their options, parameters from their classes, topics.

Usage: python -m tools.write_reference    (a test compares the pages with what it would write)
"""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_type_hints

import typer

import swarm_workbench
from swarm_bench import cli as bench_cli
from swarm_commander.cli import main as commander_cli
from swarm_commander.cli.commander_command import commander_app
from swarm_commander.cli.fleet_command import fleet_app
from swarm_common.middleware.topic_table import (
    COSTMAP_TOPICS,
    ORDERS,
    ROBOT_TOPICS,
    WORLD_TOPICS,
    Topic,
)
from swarm_map import cli as map_cli
from swarm_nav.core.config import NavConfig
from swarm_nav.core.parameter_table import ParameterRow, parameter_table
from swarm_nav.ros.settings import FIXED, FIXED_EFFECTS
from swarm_view import cli as view_cli
from swarm_workbench import RunSpec, Scenario, gym

INTERNAL = ("settle", "render")  # members that are not for users
COMPLETION = ("install_completion", "show_completion")
FOLDER = Path(__file__).resolve().parent.parent / "docs" / "reference"
WRITTEN = "<!-- written by tools/write_reference.py -->\n\n"
APPS = {
    "swarm-up": lambda: commander_cli.load_app("swarm-up"),
    "swarm-commander": lambda: commander_app,
    "swarm-commander ": lambda: fleet_app,
    "swarm-teleop": lambda: commander_cli.load_app("swarm-teleop"),
    "swarm-view": view_cli.load_view,
    "swarm-report": lambda: commander_cli.load_app("swarm-report"),
    "swarm-replay": view_cli.load_replay,
    "swarm-map": lambda: map_cli._load(),
    "swarm-bench": lambda: bench_cli._load(),
    "swarm-doctor": lambda: commander_cli.load_app("swarm-doctor"),
    "swarm-setup": lambda: commander_cli.load_app("swarm-setup"),
}


def pages() -> dict[str, str]:
    """Return the text of each page by its file name."""
    return {
        "cli.md": cli_page(),
        "parameters.md": parameter_page(),
        "topics.md": topic_page(),
        "python.md": python_page(),
    }


# Commands


def cli_page() -> str:
    """Return the page of all commands with their arguments and options."""
    parts = [
        "# Commands\n\n",
        WRITTEN,
        "Each command prints the same with `--help` or `-h`, and its release with `--version`."
        " `swarm-up --install-completion` (likewise the others) teaches your shell to complete"
        " options and names with Tab. `ros2` takes ros2cli's options. In a checkout,"
        " `python -m benchmarks --help` lists what measures the project itself. Defaults are in"
        " parentheses.\n",
    ]
    for name, load in APPS.items():
        for path, command in _commands(name.strip(), typer.main.get_command(load())):
            parts += _section(path, command)
    return "".join(parts)


def _commands(path: str, command: Any) -> Iterator[tuple[str, Any]]:
    inner = getattr(command, "commands", {})
    if not inner:
        yield path, command
    for name in sorted(inner):
        yield from _commands(f"{path} {name}", inner[name])


def _section(path: str, command: Any) -> Iterator[str]:
    yield f"\n## {path}\n\n{_cell_free(inspect.cleandoc(command.help or ''))}\n"
    shown = [item for item in command.params if item.name not in COMPLETION and not item.hidden]
    if shown:
        yield "\n"
    for item in shown:
        names = ", ".join(f"`{name}`" for name in (*item.opts, *item.secondary_opts))
        if item.param_type_name == "argument":
            names = f"`{item.name.upper()}`" + (" …" if item.nargs == -1 else "")
        text, stated = _help(item)
        yield _item(names, stated or _default(item), text)


def _item(name: str, stated: str, text: str) -> str:
    head = f"{name} ({stated})" if stated else name
    return f"- {head}: {text}\n" if text else f"- {head}\n"


def _help(item: Any) -> tuple[str, str]:
    text = _text(getattr(item, "help", "") or "")
    if isinstance(getattr(item, "show_default", None), str):
        return text, item.show_default
    match = re.fullmatch(r"(.*?) ?\[(?:default: )?([^\]]*)\]", text)
    return (match[1], match[2]) if match else (text, "")


def _default(item: Any) -> str:
    if item.required:
        return "required"
    if item.secondary_opts:
        names = item.opts if item.default else item.secondary_opts
        return f"`{names[0]}`"
    if item.default is None or isinstance(item.default, bool) or callable(item.default):
        return ""
    return f"`{item.default}`" if item.default not in ((), [], "") else ""


# Parameters


def parameter_page() -> str:
    """Return the page of a navigator's parameters."""
    parts = [
        "# Parameters of a navigator\n\n",
        WRITTEN,
        "Give a ROS 2 parameter file to `--params`, or set them while a robot drives:"
        " `ros2 param set /Srobot3/navigator traffic.patience 300.0`. `params/navigator.yaml` has"
        " all of them to copy from. Limits of speed and acceleration follow the robot model"
        " unless your file sets them.\n\nBeyond its range a parameter is refused, with a message"
        " that names it. A group may refuse more, where values do not make sense together."
        " In parentheses: default; range.\n",
    ]
    rows = parameter_table().values()
    for group, kind in get_type_hints(NavConfig).items():
        summary = (inspect.getdoc(kind) or "").splitlines()[0]
        parts.append(f"\n## {group}\n\n{summary}\n\n")
        parts += [_parameter(row) for row in rows if row.group == group]
    parts.append(
        "\n## Read once\n\nOf one robot, written by `swarm-up`; `robot.` and what follows are those"
        " of its model.\n\n"
    )
    for name, effect in FIXED_EFFECTS.items():
        parts.append(_item(f"`{name}`", _shown(FIXED[name]), _text(effect)))
    return "".join(parts)


def _parameter(row: ParameterRow) -> str:
    note = " (read once)" if row.is_fixed else ""
    default = f"{_shown(row.default)} {row.unit}".strip()
    return _item(f"`{row.name}`", f"{default}; {_range(row)}", _text(row.effect) + note)


def _shown(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _range(row: ParameterRow) -> str:
    if isinstance(row.default, bool):
        return "true, false"
    if not row.is_number:
        return ", ".join(row.choices)
    if not (row.excludes_low or row.excludes_high):
        return f"{row.low:.10g} to {row.high:.10g}"
    low = f"above {row.low:.10g}," if row.excludes_low else f"{row.low:.10g}"
    return f"{low} to {'below ' * row.excludes_high}{row.high:.10g}"


# Topics


def topic_page() -> str:
    """Return the page of topics, services and actions."""
    quality = (
        "*Reliable* topics resend what was lost; *latched* ones give latecomers the last message."
        " Names of a robot are relative to its namespace, `/Srobot1` and so on.\n"
    )
    parts = ["# Topics, services, actions\n\n", WRITTEN, quality]
    for title, topics in (
        ("Of the world", WORLD_TOPICS),
        ("Of a robot", (*ROBOT_TOPICS, *COSTMAP_TOPICS)),
        ("Taken by a robot", ORDERS),
    ):
        parts.append(f"\n## {title}\n\n")
        parts += [_item(f"`{t.name}`", "", f"`{t.type}`, {_quality(t)}") for t in topics]
    return "".join(parts) + SERVICES


def _quality(topic: Topic) -> str:
    reliable = "reliable" if topic.is_reliable else "best effort"
    return f"{reliable}, latched" if topic.is_latched else reliable


SERVICES = """
`plan`, `local_plan`, costmaps, `published_footprint`, `particle_cloud`, `imu` and what else is for
viewers are published only while somebody subscribes.

## Actions of a robot

Nav2's (`nav2_msgs/action`), with Nav2's error codes in the result: `navigate_to_pose`,
`navigate_through_poses`, `follow_waypoints`, `follow_path`, `spin`, `backup`, `drive_on_heading`,
`wait`, `compute_path_to_pose`, `compute_path_through_poses`, `smooth_path`, `assisted_teleop`;
those of [Nav2](../ros.md) that a robot refuses are there, too.

## Services of a robot

- `lifecycle_manager_navigation/manage_nodes`: `nav2_msgs/srv/ManageLifecycleNodes`
- `lifecycle_manager_navigation/is_active`: `std_srvs/srv/Trigger`
- `N/get_state`, N: [Nav2's nodes](../ros.md): `lifecycle_msgs/srv/GetState`
- `N/change_state`, `N/get_available_states`, …: `lifecycle_msgs/srv`
- `map_server/load_map`: `nav2_msgs/srv/LoadMap`
- `X/clear_entirely_X`, X: `global_costmap`, `local_costmap`: `nav2_msgs/srv/ClearEntireCostmap`
- `X/clear_around_X`, `X/clear_around_pose_X`, `X/clear_except_X`: `nav2_msgs/srv/ClearCostmap…`
- `X/get_costmap`: `nav2_msgs/srv/GetCostmap`

In a large swarm a server appears when its first client does; rarely used ones do so in any swarm.

## Services of the world

Those of [simulation_interfaces](../ros.md#simulation_interfaces) under `/sim/`; limits and refusals
are in [runtime](../runtime.md). The parameter `speed` of the node `/sim/world` is in times real
time (0: as fast as possible).
"""


# Python


def python_page() -> str:
    """Return the page of what users import: the names of `swarm_workbench`, and its `gym`."""
    parts = [
        "# Python\n\n",
        WRITTEN,
        "`from swarm_workbench import …`; the [tutorial](../tutorials/python.md) shows them at"
        " work. These names stay; what else there is may change with every release. What makes no"
        " sense raises a `SwarmError`.\n",
    ]
    names = [(name, getattr(swarm_workbench, name)) for name in swarm_workbench.__all__]
    for name, item in names:
        parts.append(f"\n## {name}\n\n")
        parts += _members(item) if isinstance(item, type) else [_function(item, item.__name__)]
    for kind in (gym.SwarmEnv, gym.RobotEnv, gym.TeamEnv):  # the rest is PettingZoo's, Gymnasium's
        parts.append(f"\n## gym.{kind.__name__}\n\n{_docstring(kind)}\n\n")
        parts.append(_function(kind.__init__, kind.__name__))
    return "".join(parts)


def _function(function: Any, name: str) -> str:
    text = f"{_signature(function, name)}\n{_docstring(function)}\n"
    return re.sub(r"\n\*\*Raises:\*\*\n\n- `(SwarmError|ConfigError)`: .*\n", "", text)


def _members(item: type) -> Iterator[str]:
    """Yield what is said of a class and of each public member that is its own."""
    yield f"{_docstring(item)}\n"
    if item not in (RunSpec, Scenario):  # they are in docs/reference/cli.md and docs/bench.md
        yield _fields(item)
    if item.__module__.partition(".")[0] != swarm_workbench.__name__:
        return  # it is known by its docstring; its fields are those of files and commands
    for name, member in vars(item).items():
        function = inspect.unwrap(getattr(member, "__func__", member))
        shown = item.__name__ if name == "__init__" and member.__doc__ else name
        if shown.startswith("_") or name in INTERNAL:
            continue
        if isinstance(member, property | functools.cached_property):
            yield f"\n- `{name}`: {_cell_free(inspect.getdoc(member) or '')}\n"
        elif inspect.isfunction(function) and member.__doc__:
            yield f"\n### {shown}\n\n{_function(function, shown)}"


def _fields(item: type) -> str:
    """Return the fields of a class of ours with the comments behind or above them."""
    found, above = [], list[str]()
    ours = [base for base in reversed(item.__mro__) if base.__module__.startswith("swarm_")]
    for line in "".join(map(inspect.getsource, ours)).splitlines():
        comment = re.match(r"    # (.*)", line)
        field = re.match(r"    ([a-z]\w*): [^#]*(.*)", line)
        text = " ".join(above) or (field[2].removeprefix("# ") if field else "")
        if field and text:
            found.append(f"- `{field[1]}`: {_cell_free(text[0].upper() + text[1:])}.\n")
        above = [*above, comment[1]] if comment else []
    return "\n**Attributes:**\n\n" + "".join(found) if found else ""


def _signature(function: Any, name: str) -> str:
    text = re.sub(r"(: |-> )'([^']+)'", r"\1\2", str(inspect.signature(function)))
    text = re.sub(r"^[(](self|cls)(, )?", "(", text)
    return f"`{name}{text if name == function.__name__ else text.removesuffix(' -> None')}`\n"


def _docstring(item: Any) -> str:
    """Return a docstring as Markdown: its sections are lists, but what it returns is a line."""
    lines: list[str] = []
    for line in (inspect.getdoc(item) or "").splitlines():
        if re.fullmatch(r"(Args|Attributes|Raises):", line):
            lines.append(f"**{line}**\n")
        elif line == "Returns:":
            lines.append("**Returns:**")
        elif lines and lines[-1] == "**Returns:**":
            lines[-1] += f" {_cell_free(line.strip())}"
        elif match := re.match(r"    (\w+): (.*)", line):
            lines.append(f"- `{match[1]}`: {_cell_free(match[2])}")
        else:
            lines.append(_cell_free(line.strip()) if line.startswith("    ") else _cell_free(line))
    return "\n".join(lines)


def _text(text: str) -> str:
    return " ".join(_cell_free(text).split())


def _cell_free(text: str) -> str:
    return text.replace("\b", "").replace("<", "&lt;").replace("*", "\\*")


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for file_name, page in pages().items():
        (FOLDER / file_name).write_text(page, encoding="utf-8")

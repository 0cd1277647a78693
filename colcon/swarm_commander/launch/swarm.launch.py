"""Starts a swarm: `ros2 launch swarm_commander swarm.launch.py swarm_size:=20 world:=warehouse`.

Its arguments are the options of `swarm-up`; true and false switch flags. Include it in a launch
file of yours with `IncludeLaunchDescription` and `launch_arguments={...}.items()`. The launch fails
when swarm-up does.
"""

import difflib
import sys

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.events.process import ProcessExited
from typer.main import get_command

from swarm_commander.cli.up_command import up_app
from swarm_ros2.launcher import swarm_up_arguments

CALL = "import sys; from swarm_commander.cli.main import swarm_up; sys.exit(swarm_up())"
LIKE = 0.75  # share of its letters from which a name is a misspelt argument


def arguments() -> dict[str, str]:
    """Return the options of swarm-up as names of launch arguments, and what they mean."""
    return {
        name.lstrip("-").replace("-", "_"): str(getattr(item, "help", None) or "")
        for item in get_command(up_app).params
        for name in item.opts
        if name.startswith("--") and name not in ("--help", "--version")
    }


def start(context: LaunchContext) -> list[object]:
    """Return swarm-up with the arguments that this launch was given."""
    known = arguments()
    given = {name: value for name, value in context.launch_configurations.items() if value}
    for name in given.keys() - known.keys():
        meant = difflib.get_close_matches(name, known, 1, LIKE)
        if meant:
            raise RuntimeError(f"unknown launch argument '{name}'; did you mean '{meant[0]}'?")
    notes = [
        LogInfo(msg=f"swarm.launch.py leaves the launch argument '{name}' alone: no option")
        for name in given
        if name not in known
    ]
    words = swarm_up_arguments([f"{name}:={given[name]}" for name in known if name in given])
    swarm = ExecuteProcess(
        cmd=[sys.executable, "-c", CALL, *words], output="screen", name="swarm_up"
    )
    return [RegisterEventHandler(OnProcessExit(target_action=swarm, on_exit=end)), *notes, swarm]


def end(event: ProcessExited, context: LaunchContext) -> list[object]:
    """Return what ends the launch with the swarm; fail if swarm-up failed."""
    if event.returncode and not context.is_shutdown:
        raise RuntimeError(f"swarm-up ended with exit code {event.returncode}")
    return [EmitEvent(event=Shutdown(reason="the swarm has ended"))]


def generate_launch_description() -> LaunchDescription:
    """Return the description that `ros2 launch` asks for."""
    declared = [
        DeclareLaunchArgument(name, default_value="", description=what or name)
        for name, what in arguments().items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])

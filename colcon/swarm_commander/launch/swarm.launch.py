"""Starts a swarm: `ros2 launch swarm_commander swarm.launch.py swarm_size:=20 world:=warehouse`.

Launch arguments are the options of `swarm-up`, with underscores; true and false switch flags. An
argument that is none is refused, and the launch fails if swarm-up does. Include it in a launch file
of yours with `IncludeLaunchDescription` and `launch_arguments={...}.items()`.
"""

import sys
from pathlib import Path

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

from swarm_run.launch_arguments import check_arguments, launch_arguments, misspelt, options_of

CALL = "import sys; from swarm_commander.cli.main import swarm_up; sys.exit(swarm_up())"


def start(context: LaunchContext) -> list[object]:
    """Return swarm-up with the arguments that this launch was given."""
    given = context.launch_configurations
    notes = []
    if any(Path(word).name == Path(__file__).name for word in sys.argv):
        check_arguments(context.argv)
    else:  # included: launch configurations are also those of other launch files
        notes = [LogInfo(msg=text) for text in misspelt(given)]
    swarm = ExecuteProcess(
        cmd=[sys.executable, "-c", CALL, *options_of(given)], output="screen", name="swarm_up"
    )
    return [*notes, RegisterEventHandler(OnProcessExit(target_action=swarm, on_exit=end)), swarm]


def end(event: object, _: LaunchContext) -> list[object]:
    """End the launch with the swarm; an exception is what makes the code of a launch 1."""
    if event.returncode:
        raise RuntimeError(f"swarm-up ended with code {event.returncode}; its messages say why")
    return [EmitEvent(event=Shutdown(reason="the swarm has ended"))]


def generate_launch_description() -> LaunchDescription:
    """Return the description that `ros2 launch` asks for."""
    arguments = [
        DeclareLaunchArgument(name, default_value="", description=text)
        for name, text in launch_arguments().items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=start)])

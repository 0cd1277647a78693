"""Starts a swarm: `ros2 launch swarm_commander swarm.launch.py swarm_size:=20 world:=warehouse`.

Launch arguments that are options of `swarm-up` are passed on; true and false switch flags. Include
it in a launch file of yours with `IncludeLaunchDescription` and `launch_arguments={...}.items()`.
"""

import sys

from launch import LaunchContext, LaunchDescription
from launch.actions import EmitEvent, ExecuteProcess, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from typer.main import get_command

from swarm_commander.cli.up_command import up_app
from swarm_ros2.launcher import swarm_up_arguments

CALL = "import sys; from swarm_commander.cli.main import swarm_up; sys.exit(swarm_up())"


def start(context: LaunchContext) -> list[object]:
    """Return swarm-up with the arguments that this launch was given."""
    options = {opt.lstrip("-") for item in get_command(up_app).params for opt in item.opts}
    given = context.launch_configurations.items()
    words = [f"{name}:={value}" for name, value in given if name.replace("_", "-") in options]
    words = swarm_up_arguments(words)
    swarm = ExecuteProcess(
        cmd=[sys.executable, "-c", CALL, *words], output="screen", name="swarm_up"
    )
    end = EmitEvent(event=Shutdown(reason="the swarm has ended"))
    return [RegisterEventHandler(OnProcessExit(target_action=swarm, on_exit=[end])), swarm]


def generate_launch_description() -> LaunchDescription:
    """Return the description that `ros2 launch` asks for."""
    return LaunchDescription([OpaqueFunction(function=start)])

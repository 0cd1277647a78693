"""`swarm-commander spawn | remove | move | list | reset | restart | record | frames`."""

from __future__ import annotations

import json
import os
import re
import signal
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Annotated, Any

import rclpy
import typer
from rclpy.node import Node
from simulation_interfaces.msg import EntityCategory, EntityFilters, Result
from simulation_interfaces.srv import (
    DeleteEntity,
    GetCurrentWorld,
    GetEntities,
    GetEntitiesStates,
    GetEntityInfo,
    ResetSimulation,
    SetEntityState,
    SpawnEntity,
)
from swarm_interfaces.msg import RobotStatus

from swarm_commander.cli.command_node import command_node, robots
from swarm_commander.cli.thing_request import thing_request
from swarm_commander.run.process_table import BAG_FILE
from swarm_commander.viewers.frame_relay import relay_frames
from swarm_common.middleware import ros_io
from swarm_common.middleware.ros_io import resource_in
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_common.model.run_words import lost_text
from swarm_common.process.messages import RestartNavigator
from swarm_common.process.pipes import EventWriter
from swarm_describe.robots.source import find_robot, robot_names
from swarm_recording.recorder import record
from swarm_recording.selection import select
from swarm_run import domain
from swarm_run.domain import domain_id
from swarm_run.robots.swarm_watch import SwarmWatch

DEFAULT_ROBOT = "turtlebot3_waffle"
NO_HINTS: Mapping[int, str] = {}
ANSWER_LIMIT = 60.0  # [s] of wall time for it to answer; it does between two ticks
ACTIVE_LIMIT = 60.0  # [s] of wall time for a new navigator to be there

fleet_app = typer.Typer(
    rich_markup_mode="rich", help="Add, remove and move robots and objects of a running swarm."
)


@fleet_app.command(
    "spawn", epilog="Example: swarm-commander spawn --robot turtlebot3_burger --pose 1 2 0"
)
def spawn(
    name: Annotated[
        str,
        typer.Argument(help="Name, like Srobot7, or an object's.", show_default="the next free"),
    ] = "",
    robot: Annotated[
        str, typer.Option(autocompletion=robot_names, help="Name or path of a robot model.")
    ] = DEFAULT_ROBOT,
    pose: Annotated[
        tuple[float, float, float] | None,
        typer.Option(
            help="X Y YAW in the map; required for objects.", show_default="a free start place"
        ),
    ] = None,
    thing: Annotated[
        str, typer.Option("--object", help="Spawn an object: .sdf, .urdf, or model://NAME.")
    ] = "",
    box: Annotated[
        tuple[float, float, float] | None, typer.Option(help="Spawn a box with edges X Y Z in m.")
    ] = None,
    cylinder: Annotated[
        tuple[float, float] | None, typer.Option(help="Spawn a cylinder with RADIUS HEIGHT in m.")
    ] = None,
    mass: Annotated[
        float | None,
        typer.Option(
            help="Mass of a box or cylinder that can be pushed, in kg; without it, it is fixed."
        ),
    ] = None,
) -> None:
    """Add a robot to a running swarm, with its navigator, or a thing."""
    if thing or box is not None or cylinder is not None:
        request = thing_request(name, thing, box, cylinder, mass, pose)
        with _node() as node:
            new = _ask(node, SpawnEntity, "spawn_entity", request).entity_name
            typer.echo(f"{new} is there, at {_place(_states(node, f'^{re.escape(new)}$')[new])}")
        return
    find_robot(robot)
    request = SpawnEntity.Request(name=name)
    resource_in(request).uri = robot
    request.initial_pose.header.frame_id = "spawn" if pose is None else "map"
    if pose is not None:
        request.initial_pose.pose = ros_io.pose_msg(Pose(*pose))
    hint = f"; for an object '{name}' give --box X Y Z, --cylinder RADIUS HEIGHT or --object FILE"
    with _node() as node:
        hints = {SpawnEntity.Response.NAME_INVALID: hint}
        new = _ask(node, SpawnEntity, "spawn_entity", request, hints).entity_name
        state = _states(node, f"^{new}$")[new]
        _wait_for_status(node, new)
    typer.echo(f"{new} is there: {robot} at {_place(state)}")


@fleet_app.command("remove", epilog="Example: swarm-commander remove Srobot3")
def remove(
    names: Annotated[
        list[str], typer.Argument(autocompletion=robots, help="Names of robots or objects.")
    ],
) -> None:
    """Remove robots, with their navigators, or objects from a running swarm."""
    with _node() as node:
        for name in names:
            _ask(node, DeleteEntity, "delete_entity", DeleteEntity.Request(entity=name))
            typer.echo(f"{name} was taken out")


@fleet_app.command("move", epilog="Example: swarm-commander move Srobot3 --pose 1 2 0")
def move(
    name: Annotated[
        str, typer.Argument(autocompletion=robots, help="Name of a robot or object, see list.")
    ],
    pose: Annotated[tuple[float, float, float], typer.Option(help="X Y YAW in the map.")],
) -> None:
    """Put a robot or a thing elsewhere; a robot's navigator is told."""
    request = SetEntityState.Request(entity=name)
    with _node() as node:
        states = _states(node, "")
        if name not in states:
            raise ConfigError(f"there is no '{name}'; there are {', '.join(states)}")
        request.state.pose = ros_io.pose_msg(Pose(*pose))
        request.state.pose.position.z = states[name].pose.position.z
        _ask(node, SetEntityState, "set_entity_state", request)
    typer.echo(f"{name} is at {_place(request.state)} now")


@fleet_app.command("list", epilog="Example: swarm-commander list")
def list_() -> None:
    """List robots, things that can be pushed, and things that came, with their true poses."""
    with _node() as node:
        states = _states(node, "")
    width = max(map(len, states), default=0)
    for name, state in states.items():
        typer.echo(f"{name.ljust(width)}  {_place(state)}")


@fleet_app.command("restart", epilog="Example: swarm-commander restart Srobot3")
def restart(
    robot: Annotated[
        str, typer.Argument(autocompletion=robots, help="Name of the robot, like Srobot3.")
    ],
) -> None:
    """Restart a robot's navigator; its mission continues with the current goal."""
    typer.echo(domain.ask(domain.domain_id(), RestartNavigator(robot), ACTIVE_LIMIT))


@fleet_app.command("reset", epilog="Example: swarm-commander reset")
def reset() -> None:
    """Remove everything spawned, and put all others back to their first poses."""
    with _node() as node:
        _ask(node, ResetSimulation, "reset_simulation", ResetSimulation.Request())
    typer.echo("all are where they were at first; simulated time and goals go on")


@fleet_app.command("record", epilog="Example: swarm-commander record --topics scan,/Srobot1/*")
def record_(
    topics: Annotated[
        str, typer.Option(help="Topics to record, as for swarm-up --record-topics.")
    ] = "",
    output: Annotated[
        Path | None, typer.Option(help="Folder of the bag.", show_default="named by the time")
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help="At most this many messages per simulated second.")
    ] = None,
) -> None:
    """Record a running swarm from now on, until Ctrl-C."""
    folder = output or Path(time.strftime("rosbag2_%Y_%m_%d-%H_%M_%S"))
    if folder.exists() and any(folder.iterdir()):
        raise ConfigError(f"{folder} is not empty")
    with _node() as node:
        world = _ask(node, GetCurrentWorld, "get_current_world", GetCurrentWorld.Request()).world
        robots = EntityFilters(categories=[EntityCategory(category=EntityCategory.CATEGORY_ROBOT)])
        names = list(
            _ask(node, GetEntities, "get_entities", GetEntities.Request(filters=robots)).entities
        )
        models = {}
        for name in names:
            request = GetEntityInfo.Request(entity=name)
            models[name] = _ask(node, GetEntityInfo, "get_entity_info", request).info.description
    select(topics, names)  # before a file is begun
    about = {"world": resource_in(world).uri, "robots": json.dumps(models)}
    config = {
        "path": str(folder / BAG_FILE),
        "robots": names,
        "topics": topics,
        "rate": rate,
        "about": about,
        "awaited": None,
    }
    typer.echo(f"recording {len(names)} robots to {folder}; Ctrl-C ends it", err=True)
    signal.signal(signal.SIGINT, lambda *_: os.kill(os.getpid(), signal.SIGTERM))
    if words := lost_text(record(config, EventWriter(None))):
        typer.echo(f"swarm-commander: {words}", err=True)
    rclpy.try_shutdown()


@fleet_app.command("frames", epilog="Example: swarm-commander frames")
def frames() -> None:
    """Relay all robots' frames to /tf and /tf_static, as Srobot3/base_link, until Ctrl-C."""
    with _node() as node:
        relay_frames(node, _tell_frames)


def _tell_frames(robots: list[str]) -> None:
    names = ", ".join(robots) or "nobody yet"
    typer.echo(f"/tf and /tf_static have the frames of {names}; Ctrl-C ends it", err=True)


def _node() -> AbstractContextManager[Node]:
    return command_node("swarm_fleet")


def _ask(
    node: Node, kind: Any, name: str, request: Any, hints: Mapping[int, str] = NO_HINTS
) -> Any:
    """Return the world's answer; `hints` are put behind its complaint, by the result's code.

    Raises:
        ConfigError: If there is no world, or it refuses.
    """
    client = node.create_client(kind, f"/sim/{name}")
    try:
        patience, start = domain.patience_for(domain_id()), time.monotonic()
        while not client.service_is_ready():
            patience.check(time.monotonic() - start)
            rclpy.spin_once(node, timeout_sec=0.1)
        future = client.call_async(request)
        _wait(
            node, future.done, ANSWER_LIMIT, "the world does not answer; do its robots all answer?"
        )
        response = future.result()
        if response.result.result != Result.RESULT_OK:
            message = response.result.error_message or f"{name} was refused"
            raise ConfigError(message + hints.get(response.result.result, ""))
        return response
    finally:
        node.destroy_client(client)


def _states(node: Node, pattern: str) -> dict[str, Any]:
    request = GetEntitiesStates.Request()
    request.filters.filter = pattern
    answer = _ask(node, GetEntitiesStates, "get_entities_states", request)
    return dict(zip(answer.entities, answer.states, strict=True))


def _wait_for_status(node: Node, name: str) -> None:
    said: list[RobotStatus] = []
    subscription = node.create_subscription(RobotStatus, f"/{name}/status", said.append, 10)
    _wait(
        node,
        lambda: bool(said),
        ACTIVE_LIMIT,
        f"{name} is in the world, but its navigator says nothing; see its log in the run folder",
    )
    node.destroy_subscription(subscription)


def _wait(node: Node, condition: Callable[[], bool], limit: float, complaint: str) -> None:
    end = time.monotonic() + limit
    watch = SwarmWatch(node)
    while not condition():
        watch.check()
        if time.monotonic() > end:
            raise ConfigError(complaint)
        rclpy.spin_once(node, timeout_sec=0.1)


def _place(state: Any) -> str:
    pose = ros_io.pose_from_msg(state.pose)
    return f"x {pose.x:z.2f}  y {pose.y:z.2f}  yaw {pose.yaw:z.2f}"

"""Reads models for the world in a process of its own.

Started as `python -m swarm_sim.world.model_reader FD PARENT`.

Any client that spawns names the files, or sends the text. A FIFO, a mesh of a hundred million
triangles or a parser that runs for minutes must not block any other process: the world ends
it after a while, and starts another for the next request. See `model_loader`.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import resource
import signal
import socket
import stat
import struct
import sys
import traceback
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from swarm_common.model.errors import SwarmError
from swarm_common.model.shapes import Box, Cylinder, Hull, Mesh, Part, Plane, Sphere
from swarm_common.process.lifetime import die_with
from swarm_describe.robots.loading import Robot, open_robot
from swarm_describe.worlds.scene import Body
from swarm_sim.world.object_source import is_object, read_object
from swarm_sim.world.request_checks import Reason, RefusedError

Model = Body | Robot
HEADER = struct.Struct("<Q")  # bytes that follow
MEMORY = 4 << 30  # [bytes] of address space
LONGEST_FILE = 20_000_000  # [bytes] of a description
MOST_SHAPES = 200  # of a model
MOST_CORNERS = 20_000  # of all its meshes
MOST_LOOKS = 1000  # shapes that are only seen
FARTHEST = 100.0  # [m] of a shape from its model's frame, and its size


@dataclass(frozen=True, slots=True)
class ModelRequest:
    """The part of a spawn request that describes the model."""

    uri: str  # name of a robot model, path or URI
    text: str  # the description itself, if there is no uri
    is_named_as_robot: bool  # whether the name that it is to have is one of a robot
    beside: Path  # folder of the world file, where models are searched, too


def read_model(request: ModelRequest) -> Model:
    """Return an object or a robot from its description, if its size is acceptable.

    Raises:
        RefusedError: With the reason, whatever is wrong with the description.
    """
    try:
        _check_file(request.uri)
        if is_object(request.uri, request.text, request.is_named_as_robot, request.beside):
            body = read_object(request.uri, request.text, request.beside)
            _check_size(body.name, body.parts)
            if len(body.visuals) > MOST_LOOKS:
                raise RefusedError(
                    Reason.BAD_MODEL, f"{len(body.visuals)} visuals; at most {MOST_LOOKS} are shown"
                )
            return body
        return read_robot(request.uri.removeprefix("file://"))
    except RefusedError:
        raise
    except SwarmError as error:
        raise RefusedError(Reason.BAD_MODEL, str(error)) from error
    except OSError as error:
        raise RefusedError(Reason.NO_MODEL, f"cannot read {request.uri}: {error}") from error
    except Exception as error:  # any exception that a library raises on unexpected input
        traceback.print_exc()
        raise RefusedError(
            Reason.BAD_MODEL, f"cannot be read: {type(error).__name__}: {error}"
        ) from error


def read_robot(name_or_path: str) -> Robot:
    """Return a robot model."""
    if not name_or_path:
        raise RefusedError(Reason.NO_MODEL, "no robot model is named")
    try:
        robot = open_robot(name_or_path)
    except SwarmError as error:
        raise RefusedError(Reason.BAD_MODEL, str(error)) from error
    _check_size(robot.spec.model, [part for group in robot.model.groups for part in group.parts])
    return robot


def _check_file(uri: str) -> None:
    """Refuse a path that is no file or folder, or too large to be a description."""
    path = Path(uri.removeprefix("file://"))
    try:
        status = path.stat()
    except FileNotFoundError:
        return  # a name, or searched elsewhere
    if stat.S_ISDIR(status.st_mode):
        return
    if not stat.S_ISREG(status.st_mode):
        raise RefusedError(Reason.NO_MODEL, f"{path} is no regular file")
    if status.st_size > LONGEST_FILE:
        raise RefusedError(
            Reason.NO_MODEL, f"{path} has {status.st_size} bytes; at most {LONGEST_FILE} are read"
        )


def _check_size(name: str, parts: Iterable[Part]) -> None:
    """Refuse a model that would hold the world up, or reach far beyond it."""
    parts = list(parts)
    if len(parts) > MOST_SHAPES:
        raise RefusedError(
            Reason.BAD_MODEL,
            f"'{name}' has {len(parts)} collision shapes; at most {MOST_SHAPES} are taken at run "
            "time: join them, or put it into the world file",
        )
    corners = 0
    for part in parts:
        reach, count = _extent(part)
        corners += count
        if not reach <= FARTHEST:
            raise RefusedError(
                Reason.BAD_MODEL,
                f"a shape of '{name}' reaches {reach:g} m from its frame; at most {FARTHEST:.0f} m",
            )
    if corners > MOST_CORNERS:
        raise RefusedError(
            Reason.BAD_MODEL,
            f"the meshes of '{name}' have {corners} corners; at most {MOST_CORNERS} are taken",
        )


def _extent(part: Part) -> tuple[float, int]:
    """Return how far [m] a shape reaches from its body's frame, and its corners."""
    shape, corners = part.shape, 0
    if isinstance(shape, Box):
        size = float(np.linalg.norm(shape.size)) / 2.0
    elif isinstance(shape, Cylinder):
        size = float(np.hypot(shape.radius, shape.length / 2.0))
    elif isinstance(shape, Sphere):
        size = shape.radius
    elif isinstance(shape, Hull | Mesh):
        points = np.asarray(shape.vertices, np.float64)
        corners, size = len(points), float(np.linalg.norm(points, axis=1).max(initial=0.0))
    else:
        assert isinstance(shape, Plane)
        size = 0.0
    return float(np.linalg.norm(part.body_from_part[:3, 3])) + size, corners


# The process


def serve(connection: socket.socket) -> None:
    """Answer requests until the world closes the connection.

    Args:
        connection: Stream socket; requests and answers are pickled, each after its length.
    """
    while (request := _receive(connection)) is not None:
        answer: Model | RefusedError
        try:
            answer = read_model(request)
        except RefusedError as error:
            answer = error
        data = pickle.dumps(answer)
        connection.sendall(HEADER.pack(len(data)) + data)


def _receive(connection: socket.socket) -> ModelRequest | None:
    header = _read(connection, HEADER.size)
    if len(header) < HEADER.size:
        return None
    request: ModelRequest = pickle.loads(_read(connection, HEADER.unpack(header)[0]))
    return request


def _read(connection: socket.socket, count: int) -> bytes:
    data = bytearray()
    while len(data) < count and (chunk := connection.recv(min(count - len(data), 1 << 20))):
        data += chunk
    return bytes(data)


def main() -> None:
    """Read models until nobody wants any more."""
    die_with(int(sys.argv[2]))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError):  # the world has ended
        serve(socket.socket(fileno=int(sys.argv[1])))
    os._exit(0)


if __name__ == "__main__":
    main()

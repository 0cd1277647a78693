"""True poses of every robot at every tick, in a file that is readable however its writer ended."""

from __future__ import annotations

import contextlib
import os
import struct
from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.records import FloatArray, IntArray

TRAJECTORY_FILE = "trajectory.bin"
_HEAD = struct.Struct("<II")  # tick, number of robots; x, y, yaw of each follow as float32


class TrajectoryWriter:
    """Appends the poses of a tick; a disk that is full ends the file, not the run."""

    def __init__(self, path: Path) -> None:
        """Begin an empty file.

        Raises:
            OSError: If it cannot be written.
        """
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC
        self._descriptor: int | None = os.open(path, flags, 0o644)

    def write(self, tick: int, poses: FloatArray, absent: Collection[int] = ()) -> None:
        """Append a tick.

        Args:
            poses: True x, y, yaw (n, 3) in the map frame.
            absent: Indices of robots that are not there; NaN is written for them.
        """
        if self._descriptor is None:
            return
        rows = poses.astype("<f4")
        rows[list(absent)] = np.nan
        try:
            os.write(self._descriptor, _HEAD.pack(tick, len(rows)) + rows.tobytes())
        except OSError:
            self.close()

    def close(self) -> None:
        """End the file; later ticks are dropped."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            with contextlib.suppress(OSError):
                os.close(descriptor)


def read_trajectory(path: Path) -> tuple[IntArray, NDArray[np.float32]]:
    """Return the ticks (T,) and poses (T, n, 3) of a file; NaN where a robot was not there.

    A tick that was cut off is left out.

    Raises:
        OSError: If there is no such file.
    """
    data = path.read_bytes()
    ticks: list[int] = []
    rows: list[NDArray[np.float32]] = []
    at = 0
    while at + _HEAD.size <= len(data):
        tick, count = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        if at + 12 * count > len(data):
            break
        rows.append(np.frombuffer(data, "<f4", 3 * count, at).reshape(count, 3))
        ticks.append(tick)
        at += 12 * count
    most = max(map(len, rows), default=0)
    poses = np.full((len(rows), most, 3), np.nan, np.float32)
    for index, row in enumerate(rows):
        poses[index, : len(row)] = row
    return np.array(ticks, np.int64), poses

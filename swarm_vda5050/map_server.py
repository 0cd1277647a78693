"""Maps from a map server: fetched, checked and compared with that of the running world; zone sets.

A link leads to a Nav2 map: its YAML, beside which its image lies, or a zip of both.
"""

from __future__ import annotations

import hashlib
import http.client
import io
import queue
import tempfile
import threading
import urllib.error
import urllib.request
import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from urllib.parse import urljoin, urlsplit

import numpy as np
import yaml
from scipy.spatial import KDTree

from swarm_common.files.map_io import load_map
from swarm_common.model.errors import SwarmError
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import FloatArray
from swarm_vda5050.maps import DIGESTS, Download

PATIENCE = 30.0  # [s] of wall time without a byte after which a server is given up
MOST_BYTES = 100_000_000  # of a file
TOLERANCE = 0.15  # [m] from a wall of one map within which the other has one
MOST_OFF = 0.02  # share of the walls that may be elsewhere
YAMLS = (".yaml", ".yml")


class DownloadError(SwarmError):
    """A file cannot be had, or does not fit."""


class DownloadEvent(NamedTuple):
    """Progress of a download."""

    action_id: str
    problem: str | None  # why it failed, empty if it did not; None as it begins
    data: bytes = b""  # of a zone set


class MapServerClient:
    """Fetches maps and zone sets in threads of its own."""

    def __init__(self, world: Grid) -> None:
        """Begin without downloads.

        Args:
            world: Map of the running world, upright.
        """
        self._world = world
        self._events: queue.SimpleQueue[DownloadEvent] = queue.SimpleQueue()

    def begin(self, download: Download) -> None:
        """Fetch a file; `poll` tells what became of it."""
        threading.Thread(target=self._fetch, args=(download,), daemon=True).start()

    def poll(self) -> list[DownloadEvent]:
        """Return what has happened since the last call."""
        events = []
        while not self._events.empty():
            events.append(self._events.get())
        return events

    def _fetch(self, download: Download) -> None:
        self._events.put(DownloadEvent(download.action_id, None))
        problem, data = "", b""
        try:
            if download.is_map:
                check_map(download.link, download.digest, self._world)
            else:
                data = _fetched(download.link, download.digest, "zoneSetHash")
        except Exception as error:  # whatever it is, the action has to end
            problem = str(error) or type(error).__name__
        self._events.put(DownloadEvent(download.action_id, problem, data))


def check_map(link: str, digest: str, world: Grid) -> None:
    """Fetch a map, and see whether it is one of the running world.

    Args:
        digest: Of the file at the link, in hex; empty for any.
        world: Map of the running world, upright.

    Raises:
        DownloadError: If it cannot be had, is not what was announced, or shows other walls.
        MapError: If it is no map.
    """
    data = _fetched(link, digest, "mapHash")
    with tempfile.TemporaryDirectory() as folder:
        if zipfile.is_zipfile(io.BytesIO(data)):
            path = _unpack(data, link, Path(folder))
        elif urlsplit(link).path.endswith(YAMLS):
            if digest:
                raise DownloadError(f"{link}: mapHash is of one file: zip the YAML and its image")
            path = Path(folder) / "map.yaml"
            path.write_bytes(data)
            image = _image_of(data, link)
            (path.parent / image).write_bytes(_read(urljoin(link, image)))
        else:
            raise DownloadError(f"{link} is neither a YAML of a Nav2 map nor a zip with one")
        try:
            grid = load_map(path).upright()
        except SwarmError as error:
            raise DownloadError(f"{link}: {str(error).replace(f'{folder}/', '')}") from None
    share = share_off(world, grid)
    if share > MOST_OFF:
        raise DownloadError(
            f"{link} does not fit the running world: {100.0 * share:.0f} % of the walls are more"
            f" than {TOLERANCE} m off"
        )


def _fetched(link: str, digest: str, name: str) -> bytes:
    data = _read(link)
    if digest and hashlib.new(DIGESTS[len(digest)], data).hexdigest() != digest.lower():
        raise DownloadError(f"{link}: the file does not have the {name} {digest:.16}…")
    return data


def share_off(one: Grid, other: Grid) -> float:
    """Return the share of the walls of two upright maps that the other one lacks."""
    walls = _walls(one), _walls(other)
    count = len(walls[0]) + len(walls[1])
    reach = TOLERANCE + max(one.resolution, other.resolution)
    off = [_count_alone(a, b, reach) for a, b in (walls, walls[::-1])]
    return sum(off) / max(count, 1)


def _count_alone(places: FloatArray, others: FloatArray, reach: float) -> int:
    if not len(places) or not len(others):
        return len(places)
    gaps, _ = KDTree(others).query(places, distance_upper_bound=reach)
    return int(np.isinf(gaps).sum())


def _walls(grid: Grid) -> FloatArray:
    """Return the places (n, 2) [m] in map of the occupied cells."""
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    size = grid.resolution
    return np.column_stack(
        (grid.origin_x + (columns + 0.5) * size, grid.origin_y + (rows + 0.5) * size)
    )


def _read(link: str) -> bytes:
    try:
        with urllib.request.urlopen(link, timeout=PATIENCE) as answer:
            data: bytes = answer.read(MOST_BYTES + 1)
    except (OSError, ValueError, http.client.HTTPException) as error:
        reason = error.reason if isinstance(error, urllib.error.URLError) else error
        raise DownloadError(f"{link:.200} cannot be had: {reason}") from None
    if len(data) > MOST_BYTES:
        raise DownloadError(f"{link:.200} has more than {MOST_BYTES} bytes")
    return data


def _image_of(data: bytes, where: str) -> str:
    """Return the name of the image that a map's YAML names; it lies beside it."""
    try:
        content = yaml.safe_load(data)
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError):
        content = None
    image = content.get("image") if isinstance(content, dict) else None
    if not isinstance(image, str) or not _is_plain(image):
        raise DownloadError(f"{where} names no image that lies beside it")
    return image


def _is_plain(name: str) -> bool:
    return name == PurePosixPath(name).name and name[:1] not in ("", ".", "~") and "\0" not in name


def _unpack(data: bytes, where: str, folder: Path) -> Path:
    """Write the map in a zip to a folder; return its YAML."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [name for name in archive.namelist() if name.endswith(YAMLS)]
            if len(names) != 1:
                raise DownloadError(f"{where} holds {len(names)} YAML files; expected one map")
            text = _member(archive, names[0], where)
            image = _image_of(text, where)
            beside = str(PurePosixPath(names[0]).parent / image)
            if beside not in archive.namelist():
                raise DownloadError(f"{where} lacks the map's image '{image:.80}'")
            (folder / image).write_bytes(_member(archive, beside, where))
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, OSError) as error:
        raise DownloadError(f"{where}: {error}") from None
    path = folder / "map.yaml"
    path.write_bytes(text)
    return path


def _member(archive: zipfile.ZipFile, name: str, where: str) -> bytes:
    with archive.open(name) as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise DownloadError(f"{where}: '{name:.80}' has more than {MOST_BYTES} bytes")
    return data

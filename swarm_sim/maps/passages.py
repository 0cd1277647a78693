"""Can every robot get to every station? If not: which passage is too narrow, and how narrow."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_common.model.errors import WorldError
from swarm_common.model.grid import KEEPOUT, OCCUPIED, Grid
from swarm_common.model.records import FloatArray, Mask, Pose, RobotSpec
from swarm_describe.worlds.scene import GROUND_GAP, Scene
from swarm_sim.maps.raster import draw_grid
from swarm_sim.maps.spawn import wall_distance
from swarm_sim.scene.section import section_between

Cell = tuple[int, int]
RESOLUTION = 0.05  # [m] of the grid on which ways are looked for
ROOM = 0.04  # [m] beyond the robot's circle that its planner keeps from walls
SLACK = 0.03  # [m] by which the grid may show a passage too narrow
ACROSS = 0.08  # [m] to either side of a cell in which the middle of the passage is looked for
NEAR = 0.3  # [m] from a station within which a robot has come to it
STEPS = 12  # of the search for the width of the widest way


@dataclass(frozen=True, slots=True)
class Passage:
    """The narrowest place of the widest way; metres in the map."""

    x: float
    y: float
    width: float


def check_ways(scene: Scene, specs: Sequence[RobotSpec], poses: Sequence[Pose]) -> None:
    """Check that the widest robot of each height gets from its start to every station and place.

    Raises:
        WorldError: Naming the station, and the passage that is too narrow for which robot.
    """
    targets = {f"station '{name}'": pose for name, pose in scene.sites.stations.items()}
    targets |= {f"place {i}": pose for i, pose in enumerate(scene.sites.places, 1)}
    if not targets:
        return
    for spec in {(s.height, needed_width(s)): s for s in specs}.values():
        ways = Ways(scene, spec.height)
        starts = [p for s, p in zip(specs, poses, strict=True) if s is spec or s == spec]
        need = 0.5 * needed_width(spec)
        for name, target in targets.items():
            for start in ways.cut_off(starts, target, need - SLACK):
                raise WorldError(_message(scene, spec, name, start, need, ways, target))


def needed_width(spec: RobotSpec) -> float:
    """Return the width [m] that a passage needs: long robots pass it straight."""
    half = spec.half_width if spec.is_oblong else spec.circumscribed_radius
    return 2.0 * (half + ROOM)


def _message(
    scene: Scene, spec: RobotSpec, name: str, start: Pose, need: float, ways: Ways, target: Pose
) -> str:
    passage = ways.narrowest(start, target)
    head = (
        f"no {spec.model} can get from its start at ({start.x:.2f}, {start.y:.2f}) to {name} of "
        f"world '{scene.name}'"
    )
    if scene.sites.zones.has_keepout:
        head += ", keepout zones counted as walls"
    if passage is None:
        return f"{head}: there is no way at all between the two"
    return (
        f"{head}: the widest way leads through a passage of about {passage.width:.2f} m "
        f"at ({passage.x:.2f}, {passage.y:.2f}); this robot needs {2.0 * need:.2f} m"
    )


class Ways:
    """Distances to the nearest obstacle between ground and a robot's height, on a grid."""

    def __init__(self, scene: Scene, height: float) -> None:
        """Lay out the grid.

        Args:
            scene: World with its sites; the grid covers these, too.
        """
        from scipy.ndimage import distance_transform_edt  # slow to import

        self._labels: dict[float, NDArray[np.int32]] = {}  # of the last room asked for
        self._section = section_between(scene.bodies, GROUND_GAP, height)
        sites = [(p.x, p.y) for p in (*scene.sites.stations.values(), *scene.sites.places)]
        seeds = np.array(sites, np.float64).reshape(-1, 2)
        self._grid: Grid = draw_grid(self._section, seeds, RESOLUTION)
        is_free = self._grid.cells != OCCUPIED
        self._has_keepout = scene.sites.zones.has_keepout
        if self._has_keepout:
            is_free &= scene.sites.zones.mark(self._grid).keepout != KEEPOUT
        self._clear: FloatArray = np.where(
            is_free, distance_transform_edt(is_free) * RESOLUTION - 0.5 * RESOLUTION, 0.0
        )

    def cut_off(self, starts: Sequence[Pose], target: Pose, room: float) -> list[Pose]:
        """Return the starts from which no way leads to the target.

        Args:
            target: In the map frame; within `NEAR` of it is there.
            room: [m] between the robot's centre and any wall.
        """
        labels = self._parts(room)
        there = self._labels_near(labels, target)
        return [start for start in starts if not there & self._labels_near(labels, start)]

    def narrowest(self, start: Pose, target: Pose) -> Passage | None:
        """Return the narrowest place of the widest way between two poses, None without any way."""
        low, high = 0.5 * RESOLUTION, float(self._clear.max())
        if self.cut_off([start], target, low):
            return None
        for _ in range(STEPS):
            middle = 0.5 * (low + high)
            if self.cut_off([start], target, middle):
                high = middle
            else:
                low = middle
        path = self._path(start, target, low)
        if not path:
            return None
        parts = self._parts(high)
        home, there = (self._labels_near(parts, pose) for pose in (start, target))
        labels = [int(parts[cell]) for cell in path]
        left = max((i for i, label in enumerate(labels) if label in home), default=-1)
        came = next((i for i in range(left + 1, len(path)) if labels[i] in there), len(path))
        return self._measured(min(path[left + 1 : came] or path, key=lambda c: self._clear[c]))

    def _measured(self, cell: Cell) -> Passage:
        """Return the passage around a cell; its width is measured between the bodies themselves."""
        x, y = self._grid.center_of(*cell)
        if self._has_keepout:  # whose borders are no bodies
            return Passage(x, y, 2.0 * float(self._clear[cell]))
        offsets = np.linspace(-ACROSS, ACROSS, 9)
        directions = np.linspace(0.0, np.pi, 8, endpoint=False)
        way = np.column_stack([np.cos(directions), np.sin(directions)])
        points = np.array([x, y]) + offsets[None, :, None] * way[:, None, :]
        gaps = wall_distance(points.reshape(-1, 2), self._section).reshape(8, 9)
        # across a passage its middle is the largest, along it the narrowest place the smallest
        return Passage(x, y, 2.0 * float(gaps.max(axis=1).min()))

    def _parts(self, room: float) -> NDArray[np.int32]:
        """Return the connected part of each cell with enough clearance, 0 for all other cells."""
        from scipy.ndimage import label

        if room not in self._labels:
            self._labels = {room: label(self._clear >= room, structure=np.ones((3, 3)))[0]}
        return self._labels[room]

    def _labels_near(self, labels: NDArray[np.int32], pose: Pose) -> set[int]:
        row, column = self._grid.cell_of(pose.x, pose.y)
        reach = round(NEAR / RESOLUTION)
        window = labels[
            max(0, row - reach) : max(0, row + reach + 1),
            max(0, column - reach) : max(0, column + reach + 1),
        ]
        return {int(value) for value in np.unique(window)} - {0}

    def _path(self, start: Pose, target: Pose, room: float) -> list[Cell]:
        """Return the cells of a shortest way through cells with enough clearance."""
        mask = self._clear >= room
        first, last = (self._nearest(mask, pose) for pose in (start, target))
        before: dict[Cell, Cell] = {first: first}
        queue = deque([first])
        while queue and last not in before:
            cell = queue.popleft()
            for dr in (-1, 0, 1):
                for dc in (-1, 0, 1):
                    after = (cell[0] + dr, cell[1] + dc)
                    is_inside = 0 <= after[0] < mask.shape[0] and 0 <= after[1] < mask.shape[1]
                    if is_inside and mask[after] and after not in before:
                        before[after] = cell
                        queue.append(after)
        if last not in before:
            return []
        path = [last]
        while path[-1] != first:
            path.append(before[path[-1]])
        return path[::-1]

    def _nearest(self, mask: Mask, pose: Pose) -> Cell:
        cells = np.argwhere(mask)
        row, column = self._grid.cell_of(pose.x, pose.y)
        best = int(np.argmin(((cells - np.array([row, column])) ** 2).sum(axis=1)))
        return int(cells[best, 0]), int(cells[best, 1])

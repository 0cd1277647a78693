"""Checks that map, LiDARs and physics engine show a world as its file describes it.

The raw triangles of each body are compared with the three representations. The result is
cached: a world is checked once, as long as neither its geometry nor this code changes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swarm_common.files.storage import kept
from swarm_common.model.engines import BULLET, check_engine
from swarm_common.model.errors import WorldError
from swarm_common.model.grid import COARSEST, OCCUPIED, Grid
from swarm_common.model.records import FloatArray
from swarm_common.model.shapes import Mesh
from swarm_describe.worlds.raw_triangles import cuts, points_along, triangles_between, triangles_of
from swarm_describe.worlds.scene import Body, Scene
from swarm_sim.maps.draw_map import Reach
from swarm_sim.maps.map_difference import MapDifference, grown
from swarm_sim.maps.raster import draw_grid, draw_on
from swarm_sim.maps.spawn import wall_distance
from swarm_sim.scene.section import Section, section_between

STEP = COARSEST / 2.0  # [m] between points that are looked at
MOST_POINTS = 40_000  # of a body; of a larger one every so many
LATTICE = 1e-6  # [m] to which corners are rounded where outlines are joined
SLIT = 1e-3  # [m] twice as wide is a gap between pieces of one surface, at most
NAMED = 8  # differences that a message lists
CODE = (
    "scene/section", "scene/mesh_section", "scene/mesh_kernels", "scene/polygon_pieces",
    "../swarm_describe/worlds/raw_triangles", "maps/raster", "maps/world_check",
    "physics/bullet/probe", "physics/bullet/fixed_bodies", "physics/bullet/object_bodies",
    "physics/bullet/collision_shapes",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Difference:
    """Difference between something that is made of a body and the body's triangles."""

    body: str  # its name
    what: str  # "the map", "the LiDAR" or "the physics engine", and whether it lacks or invents it
    x: float  # [m] where most
    y: float  # [m] where most
    count: int  # points that differ by more than a cell

    def __str__(self) -> str:
        """Return it as a line of a message."""
        return f"'{self.body}': {self.what} around ({self.x:.2f}, {self.y:.2f})"


def checked(
    scene: Scene,
    scan_heights: Sequence[float],
    reach: Reach,
    *,
    with_physics: bool,
    skip_broken: bool = False,
) -> Scene:
    """Return a world that is as its file has it; the result of the comparison is cached.

    Args:
        reach: Heights between which robots can touch something.
        skip_broken: Whether bodies that differ are left out.

    Raises:
        WorldError: Naming the bodies, and what differs where.
    """
    heights = tuple(sorted(set(scan_heights)))
    parts: list[str | bytes] = [
        *_code(),
        *_content(scene.bodies),
        repr((heights, reach, with_physics)),
    ]
    found = kept(
        "worlds",
        parts,
        lambda: tuple(differences(scene, heights, reach, with_physics=with_physics)),
    )
    if found and skip_broken:
        names = {difference.body for difference in found}
        note = f"left out, because it differs from its triangles: {', '.join(sorted(names))}"
        bodies = tuple(body for body in scene.bodies if body.name not in names)
        return replace(scene, bodies=bodies, notes=(*scene.notes, note))
    if found:
        lines = [f"  {difference}" for difference in found[:NAMED]]
        if len(found) > NAMED:
            lines.append(f"  and {len(found) - NAMED} more")
        raise WorldError(
            f"{scene.file}: what is made of these bodies differs from their triangles by more "
            f"than {COARSEST} m:\n" + "\n".join(lines) + "\nleave them out with --skip-broken, "
            f"or see where: swarm-map check {scene.file}"
        )
    return scene


def differences(
    scene: Scene, scan_heights: Sequence[float], reach: Reach, *, with_physics: bool
) -> Iterator[Difference]:
    """Compare what is made of each body with its triangles; on the map are the fixed ones.

    Raises:
        ConfigError: If the physics engine is asked for and not installed.
    """
    for body in scene.bodies:
        triangles = triangles_of([body])
        for height in scan_heights:
            segments = cuts(triangles, height)
            section = section_between([body], height, height)
            yield from _compared(body.name, "the LiDAR", segments, section)
        segments = triangles_between(triangles, *reach)
        section = section_between([body], *reach)
        yield from _compared(body.name, "what robots can touch", segments, section)
        if body.is_static:
            yield from _on_map(body.name, _few(points_along(segments, STEP)), section)
    if with_physics:
        check_engine(BULLET, "a comparison with physics")
        yield from _felt(scene.bodies, reach)


def picture(scene: Scene, reach: Reach) -> MapDifference:
    """Return the map of a world compared with the triangles, on the map's cells."""
    section = section_between(scene.fixed, *reach)
    points = _few(points_along(triangles_between(triangles_of(scene.fixed), *reach), STEP))
    grid = draw_grid(section, points[:: max(1, len(points) // MOST_POINTS)])
    grid = draw_on(
        (grid.height, grid.width), grid.resolution, grid.origin_x, grid.origin_y, section
    )
    drawn, truth = grid.cells == OCCUPIED, _mask(grid, points)
    rim = drawn & grown(~drawn, 1)
    return MapDifference(
        grid=grid,
        truth=truth,
        drawn=drawn,
        missing=truth & ~grown(drawn, 1),
        invented=rim & ~grown(truth, 2),
        outside="",
    )


def _compared(name: str, what: str, segments: FloatArray, section: Section) -> Iterator[Difference]:
    """Compare segments (n, 2, 2) on the triangles of a body with its outlines."""
    import shapely  # slow to import, and not needed for what is in the cache

    points = _few(points_along(segments, STEP))
    missing = points[wall_distance(points, section) > COARSEST]
    yield from _difference(name, f"{what} lacks it", missing)
    outlines = [shapely.Polygon(outline) for outline in section.outlines()]
    # closed where two pieces of one surface leave a slit between them, which is no rim
    area = shapely.union_all(outlines, grid_size=LATTICE).buffer(SLIT).buffer(-SLIT)
    coordinates, ring = shapely.get_coordinates(
        shapely.get_parts(shapely.boundary(shapely.get_parts(area))), return_index=True
    )
    follows = np.flatnonzero(ring[1:] == ring[:-1])
    rim = points_along(np.stack([coordinates[follows], coordinates[follows + 1]], axis=1), STEP)
    rim = _few(rim)
    if len(rim):
        gaps = np.full(len(rim), np.inf)
        if len(segments):
            tree = shapely.STRtree(shapely.linestrings(segments))
            (which, _), found = tree.query_nearest(shapely.points(rim), return_distance=True)
            gaps[which] = found
        yield from _difference(name, f"{what} has more of it", rim[gaps > COARSEST])


def _on_map(name: str, points: FloatArray, section: Section) -> Iterator[Difference]:
    """Compare points (n, 2) on the triangles of a body with the map's cells."""
    if not len(points):
        return
    grid = draw_grid(section, np.vstack([points.min(axis=0), points.max(axis=0)])[:0])
    mask = grown(grid.cells == OCCUPIED, 1)
    cells = _cells(grid, points)
    inside = ((cells >= 0) & (cells < mask.shape)).all(axis=1)
    is_there = np.zeros(len(points), np.bool_)
    is_there[inside] = mask[cells[inside, 0], cells[inside, 1]]
    yield from _difference(name, "the map lacks it", points[~is_there])


def _felt(bodies: Sequence[Body], reach: Reach) -> Iterator[Difference]:
    from swarm_sim.physics.bullet.probe import lacking  # pybullet is slow to import

    for body in bodies:
        missed = lacking(body, *reach, COARSEST)[:, :2]
        yield from _difference(body.name, "the physics engine lacks it", missed)


def _difference(name: str, what: str, points: FloatArray) -> Iterator[Difference]:
    if len(points):
        x, y = points[len(points) // 2]
        yield Difference(name, what, float(x), float(y), len(points))


def _few(points: FloatArray) -> FloatArray:
    kept_ones: FloatArray = np.ascontiguousarray(points[:: max(1, len(points) // MOST_POINTS)])
    return kept_ones


def _cells(grid: Grid, points: FloatArray) -> NDArray[np.int64]:
    corner = np.array([grid.origin_x, grid.origin_y])
    cells: NDArray[np.int64] = np.floor((points - corner) / grid.resolution).astype(np.int64)
    return cells[:, ::-1]


def _mask(grid: Grid, points: FloatArray) -> NDArray[np.bool_]:
    mask = np.zeros(grid.cells.shape, np.bool_)
    cells = _cells(grid, points)
    cells = cells[((cells >= 0) & (cells < mask.shape)).all(axis=1)]
    mask[cells[:, 0], cells[:, 1]] = True
    return mask


def _content(bodies: Sequence[Body]) -> Iterator[bytes]:
    """Return all that the result depends on of bodies."""
    for body in bodies:
        yield repr((body.name, body.is_static)).encode()
        yield np.ascontiguousarray(body.world_from_body).tobytes()
        for part in body.parts:
            yield np.ascontiguousarray(part.body_from_part).tobytes()
            if isinstance(part.shape, Mesh):
                yield hashlib.sha256(part.shape.vertices.tobytes()).digest()
                yield hashlib.sha256(part.shape.faces.tobytes()).digest()
            else:
                yield repr(part.shape).encode()


def _code() -> Iterator[bytes]:
    package = Path(__file__).resolve().parents[1]
    for name in CODE:
        yield (package / f"{name}.py").read_bytes()

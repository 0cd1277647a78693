"""The fixed scene, drawn once: floor map, bodies, stations, circuits, layout; and the walkers."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import viser
from visualization_msgs.msg import Marker

from swarm_common.model.palette import RGB, linear
from swarm_common.model.records import FloatArray
from swarm_describe.files.meshes import open_mesh
from swarm_view.scene.images import map_image
from swarm_view.scene.shapes import lifted, polyline, raised
from swarm_view.state.decode import Raster, layout_points

LOG = logging.getLogger(__name__)
FLIPPED = (0.0, 1.0, 0.0, 0.0)  # about x: viser's images look down and hang upside down
WALL_HEIGHT, WALL_OPACITY = 1.2, 0.45  # [m] from which robots must be seen through a body
CUT_HEIGHT = 0.5  # [m] at which bodies are cut
LINE_PIXELS = 2.5  # width of a circuit
FLOOR = 0.004  # [m] height of what is painted on the floor: the robots' marks lie above it
UPRIGHT = 0.999  # least share of a body's axis that points up or down, for a cut in its height
MAP, WHOLE, CUT = "/map", "/world/whole", "/world/cut"
MAP_HEIGHT = -0.005  # [m] below everything else
UNIT = {
    Marker.CUBE: trimesh.creation.box((1.0, 1.0, 1.0)),
    Marker.CYLINDER: trimesh.creation.cylinder(0.5, 1.0, sections=32),
    Marker.SPHERE: trimesh.creation.icosphere(subdivisions=3, radius=0.5),
}

Turn = tuple[float, float, float, float]
Triple = tuple[float, float, float]
Box = tuple[Turn, Triple, Triple]  # how it is turned, its middle, its size


def draw_image(scene: Any, name: str, raster: Raster, image: Any, height: float) -> Any:
    """Draw a grid flat on the floor; return its handle."""
    width, depth = raster.size
    return scene.add_image(
        name, image, width, depth, position=(*raster.center, height), wxyz=FLIPPED, format="png",
        cast_shadow=False, receive_shadow=False,
    )  # fmt: skip


class Scenery:
    """The part of the scene that all pages share.

    Bodies are drawn twice, of which each page sees one: as they are, see-through where they are
    tall, and cut at `CUT_HEIGHT`, so that robots behind them are seen.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._movers: dict[tuple[Any, ...], Any] = {}
        self._numbers = itertools.count()  # so that no name is used twice

    def draw_map(self, raster: Raster) -> None:
        """Draw the map on the floor."""
        draw_image(self._scene, MAP, raster, map_image(raster), MAP_HEIGHT)

    def draw_markers(self, markers: list[Any]) -> None:
        """Draw the world: equal shapes in one go."""
        self._scene.add_frame(WHOLE, show_axes=False, visible=False)
        self._scene.add_frame(CUT, show_axes=False)
        solids: dict[tuple[int, RGB, bool], list[Any]] = {}
        for marker in markers:
            if marker.type in UNIT:
                key = marker.type, _rgb(marker), marker.scale.z > WALL_HEIGHT
                solids.setdefault(key, []).append(marker)
            elif marker.type == Marker.TRIANGLE_LIST:
                self._draw_triangles(marker)
            elif marker.type == Marker.MESH_RESOURCE:
                self._draw_file(marker)
            elif marker.type == Marker.LINE_STRIP:
                points = np.array([(p.x, p.y) for p in marker.points])
                self._scene.add_line_segments(
                    f"/world/{marker.ns}_{marker.id}",
                    polyline(points, FLOOR),
                    _rgb(marker),
                    thickness=LINE_PIXELS,
                    thickness_units="screen",  # cheaper than metres
                )
            elif marker.type == Marker.LINE_LIST:
                lines = layout_points([marker], Marker.LINE_LIST).reshape(-1, 2, 2)
                self._scene.add_line_segments(
                    f"/world/{marker.ns}", raised(lines, FLOOR), _rgb(marker),
                    thickness=LINE_PIXELS, thickness_units="screen",
                )  # fmt: skip
            elif marker.type == Marker.POINTS:
                self._scene.add_point_cloud(
                    f"/world/{marker.ns}",
                    lifted(layout_points([marker], Marker.POINTS), FLOOR),
                    _rgb(marker),
                    point_size=marker.scale.x,
                    point_shape="circle",
                    point_shading="flat",
                )
        for number, ((kind, color, is_tall), group) in enumerate(solids.items()):
            boxes = [_box(marker) for marker in group]
            opacity = WALL_OPACITY if is_tall else None
            self._draw_solids(f"{WHOLE}/solids_{number}", kind, color, boxes, opacity)
            low = [found for box in boxes if (found := _below_cut(*box)) is not None]
            if low:
                self._draw_solids(f"{CUT}/solids_{number}", kind, color, low, None)

    def _draw_solids(
        self, name: str, kind: int, color: RGB, boxes: list[Box], opacity: float | None
    ) -> None:
        mesh = UNIT[kind]
        turns, places, sizes = zip(*boxes, strict=True)
        self._scene.add_batched_meshes_simple(
            name, mesh.vertices, mesh.faces,
            batched_wxyzs=np.array(turns), batched_positions=np.array(places),
            batched_scales=np.array(sizes, np.float32),
            batched_colors=linear(color), lod="off", flat_shading=kind == Marker.CUBE,
            opacity=opacity, cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def _draw_mesh(self, marker: Any, mesh: Any, add: Callable[..., Any]) -> None:
        """Draw a mesh whole and cut, each with `add`."""
        turn, place = _turn(marker), np.array(_place(marker))
        axis = _axes(turn)[2]  # upright, in the mesh's frame
        low = mesh.slice_plane(axis * (CUT_HEIGHT - place[2]), -axis)
        for root, part in ((WHOLE, mesh), (CUT, low)):
            if len(part.faces):
                add(
                    f"{root}/{marker.ns}_{marker.id}", part, position=place, wxyz=turn,
                    cast_shadow=False, receive_shadow=False,
                )  # fmt: skip

    def _draw_triangles(self, marker: Any) -> None:
        def add(name: str, mesh: Any, **options: Any) -> None:
            vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
            options |= {"color": _rgb(marker), "flat_shading": True, "side": "double"}
            self._scene.add_mesh_simple(name, vertices, faces, **options)

        self._draw_mesh(marker, trimesh.Trimesh(*_triangles(marker), process=False), add)

    def _draw_file(self, marker: Any) -> None:
        path = Path(marker.mesh_resource.removeprefix("file://"))
        try:
            scene, unit = open_mesh(path)
            mesh = scene.to_mesh().apply_scale(unit * np.array(_size(marker)))
        except Exception as error:  # whatever a reader raises at a damaged file
            LOG.warning("%s is not drawn: %s", path, error)
            return
        self._draw_mesh(marker, mesh, self._scene.add_mesh_trimesh)

    def draw_movers(self, markers: list[Any]) -> None:
        """Draw the people and objects among the markers; remove those that are no longer there."""
        known, self._movers = self._movers, {}
        for marker in markers:
            if marker.action != Marker.ADD or marker.type not in (*UNIT, Marker.TRIANGLE_LIST):
                continue
            key = (
                marker.ns, marker.id, marker.type, _rgb(marker), _size(marker), len(marker.points),
            )  # fmt: skip
            handle = known.pop(key, None) or self._mover(marker)
            handle.position, handle.wxyz = _place(marker), _turn(marker)
            self._movers[key] = handle
        for handle in known.values():
            handle.remove()

    def _mover(self, marker: Any) -> Any:
        mesh = UNIT.get(marker.type)
        shape = _triangles(marker) if mesh is None else (mesh.vertices, mesh.faces)
        return self._scene.add_mesh_simple(
            f"/movers/{marker.ns}_{marker.id}_{next(self._numbers)}", *shape,
            color=_rgb(marker), scale=_size(marker), side="double",
            cast_shadow=False, receive_shadow=False,
        )  # fmt: skip


def _box(marker: Any) -> Box:
    size = _size(marker)
    x, y, z = _place(marker)
    return _turn(marker), (x, y, FLOOR - 0.5 * size[2] if marker.ns == "station" else z), size


def _triangles(marker: Any) -> tuple[FloatArray, Any]:
    points = np.array([(p.x, p.y, p.z) for p in marker.points]).reshape(-1, 3)
    return points, np.arange(len(points)).reshape(-1, 3)


def _size(marker: Any) -> Triple:
    return marker.scale.x, marker.scale.y, marker.scale.z


def _below_cut(turn: Turn, place: Triple, size: Triple) -> Box | None:
    """Return what is left of a body below the cut; all of it if it is inclined, None if nothing."""
    if abs(_axes(turn)[2, 2]) < UPRIGHT:
        return (turn, place, size) if place[2] < CUT_HEIGHT else None
    bottom, top = place[2] - 0.5 * size[2], place[2] + 0.5 * size[2]
    if bottom >= CUT_HEIGHT:
        return None  # a ceiling, a lintel
    top = min(top, CUT_HEIGHT)
    middle = place[0], place[1], 0.5 * (bottom + top)
    return turn, middle, (size[0], size[1], top - bottom)


def _axes(turn: Turn) -> FloatArray:
    """Return the axes of map (3, 3) in the frame of a body, one a row."""
    axes: FloatArray = trimesh.transformations.quaternion_matrix(turn)[:3, :3]
    return axes


def _rgb(marker: Any) -> RGB:
    color = marker.color
    return round(255 * color.r), round(255 * color.g), round(255 * color.b)


def _place(marker: Any) -> Triple:
    place = marker.pose.position
    return place.x, place.y, place.z


def _turn(marker: Any) -> Turn:
    turn = marker.pose.orientation
    return turn.w, turn.x, turn.y, turn.z

"""The fixed scene, drawn once: floor map, bodies, stations, circuits; and the walkers."""

from __future__ import annotations

import itertools
import logging
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import viser
from visualization_msgs.msg import Marker

from swarm_common.model.palette import RGB, linear
from swarm_view.decode import Raster
from swarm_view.images import map_image
from swarm_view.shapes import polyline

LOG = logging.getLogger(__name__)
FLIPPED = (0.0, 1.0, 0.0, 0.0)  # about x: viser's images look down and hang upside down
WALL_HEIGHT, WALL_OPACITY = 1.2, 0.45  # [m] from which robots must be seen through a body
MAP_HEIGHT = -0.005  # [m] below everything else
UNIT = {
    Marker.CUBE: trimesh.creation.box((1.0, 1.0, 1.0)),
    Marker.CYLINDER: trimesh.creation.cylinder(0.5, 1.0, sections=32),
    Marker.SPHERE: trimesh.creation.icosphere(subdivisions=3, radius=0.5),
}


def draw_image(scene: Any, name: str, raster: Raster, image: Any, height: float) -> Any:
    """Draw a grid flat on the floor; return its handle."""
    width, depth = raster.size
    return scene.add_image(
        name, image, width, depth, position=(*raster.center, height), wxyz=FLIPPED, format="png",
        cast_shadow=False, receive_shadow=False,
    )  # fmt: skip


class Scenery:
    """The part of the scene that all pages share and no page changes."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Draw nothing yet."""
        self._scene = server.scene
        self._movers: dict[tuple[Any, ...], Any] = {}
        self._numbers = itertools.count()  # so that no name is used twice

    def draw_map(self, raster: Raster) -> None:
        """Draw the map on the floor."""
        draw_image(self._scene, "/map", raster, map_image(raster), MAP_HEIGHT)

    def draw_markers(self, markers: list[Any]) -> None:
        """Draw the world: equal shapes in one go."""
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
                    f"/world/{marker.ns}_{marker.id}", polyline(points, 0.02), _rgb(marker),
                    thickness=marker.scale.x,
                )  # fmt: skip
            elif marker.type == Marker.TEXT_VIEW_FACING:
                place = marker.pose.position
                self._scene.add_label(
                    f"/stations/{marker.text}", marker.text,
                    position=(place.x, place.y, place.z), anchor="bottom-center",
                    font_screen_scale=0.9,
                )  # fmt: skip
        for number, ((kind, color, _), group) in enumerate(solids.items()):
            self._draw_solids(f"/world/solids_{number}", kind, color, group)

    def _draw_solids(self, name: str, kind: int, color: RGB, group: list[Any]) -> None:
        mesh = UNIT[kind]
        self._scene.add_batched_meshes_simple(
            name, mesh.vertices, mesh.faces,
            batched_wxyzs=np.array([_turn(marker) for marker in group]),
            batched_positions=np.array([_place(marker) for marker in group]),
            batched_scales=np.array([(m.scale.x, m.scale.y, m.scale.z) for m in group], np.float32),
            batched_colors=linear(color), lod="off", flat_shading=kind == Marker.CUBE,
            opacity=WALL_OPACITY if group[0].scale.z > WALL_HEIGHT else None,
            cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def _draw_triangles(self, marker: Any) -> None:
        vertices = np.array([(p.x, p.y, p.z) for p in marker.points]).reshape(-1, 3)
        faces = np.arange(len(vertices)).reshape(-1, 3)
        self._scene.add_mesh_simple(
            f"/world/{marker.ns}_{marker.id}", vertices, faces, color=_rgb(marker),
            flat_shading=True, side="double", position=_place(marker), wxyz=_turn(marker),
            cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def _draw_file(self, marker: Any) -> None:
        path = Path(marker.mesh_resource.removeprefix("file://"))
        try:
            mesh = trimesh.load_mesh(path)
            mesh.apply_scale((marker.scale.x, marker.scale.y, marker.scale.z))
        except Exception as error:  # whatever a reader raises at a damaged file
            LOG.warning("%s is not drawn: %s", path, error)
            return
        self._scene.add_mesh_trimesh(
            f"/world/{marker.ns}_{marker.id}", mesh, position=_place(marker), wxyz=_turn(marker),
            cast_shadow=False, receive_shadow=False,
        )  # fmt: skip

    def draw_movers(self, markers: list[Any]) -> None:
        """Draw the people and objects among the markers; remove those that are no longer there."""
        known, self._movers = self._movers, {}
        for marker in markers:
            if marker.action != Marker.ADD or marker.type not in (*UNIT, Marker.TRIANGLE_LIST):
                continue
            size = marker.scale.x, marker.scale.y, marker.scale.z
            key = marker.ns, marker.id, marker.type, _rgb(marker), size, len(marker.points)
            handle = known.pop(key, None) or self._mover(marker)
            handle.position, handle.wxyz = _place(marker), _turn(marker)
            self._movers[key] = handle
        for handle in known.values():
            handle.remove()

    def _mover(self, marker: Any) -> Any:
        if marker.type in UNIT:
            mesh = UNIT[marker.type]
            vertices, faces = mesh.vertices, mesh.faces
        else:
            vertices = np.array([(p.x, p.y, p.z) for p in marker.points]).reshape(-1, 3)
            faces = np.arange(len(vertices)).reshape(-1, 3)
        return self._scene.add_mesh_simple(
            f"/movers/{marker.ns}_{marker.id}_{next(self._numbers)}", vertices, faces,
            color=_rgb(marker), scale=(marker.scale.x, marker.scale.y, marker.scale.z),
            side="double", cast_shadow=False, receive_shadow=False,
        )  # fmt: skip


def _rgb(marker: Any) -> RGB:
    color = marker.color
    return round(255 * color.r), round(255 * color.g), round(255 * color.b)


def _place(marker: Any) -> tuple[float, float, float]:
    place = marker.pose.position
    return place.x, place.y, place.z


def _turn(marker: Any) -> tuple[float, float, float, float]:
    turn = marker.pose.orientation
    return turn.w, turn.x, turn.y, turn.z

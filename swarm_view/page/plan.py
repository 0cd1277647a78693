"""*Plan*, the swarm from above: what the canvas of one page is told (swarm_view/server/plan.js)."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from PIL import Image
from scipy.spatial import ConvexHull
from visualization_msgs.msg import Marker

from swarm_common.model.palette import css, state_color
from swarm_common.model.records import FloatArray
from swarm_common.model.run_words import waits_for
from swarm_view.scene.images import DARK, LIGHT, map_image
from swarm_view.scene.robot_mesh import RobotMesh
from swarm_view.scene.viser_compat import run_script
from swarm_view.state.decode import ReportedState
from swarm_view.state.swarm import Swarm
from swarm_view.state.topics import Layer

FROM = 30  # robots from which on it is the first thing that a page shows
MOST_TUBES = 40  # robots up to which held space is shown without being asked for
MOST_QUEUED = 3  # robots of a queue that are named
ROUND = 12  # corners of a moving cylinder


class PlanView:
    """The canvas of one page; sends what has changed."""

    def __init__(self, client: Any) -> None:
        self.is_on = False
        self._client = client
        self._sent: dict[str, Any] = {}

    def show(self, *, is_on: bool) -> None:
        """Show it in place of the scene, or no more."""
        if is_on != self.is_on:
            self.is_on = is_on
            self._run(f"show({json.dumps(is_on)})")

    def fit(self) -> None:
        """Show the whole hall again."""
        self._run("fit()")

    def follow(self, *, is_wanted: bool) -> None:
        """Keep the chosen robot in the middle, or no more."""
        self._run(f"follows = {json.dumps(is_wanted)}")

    def move(self, poses: FloatArray) -> None:
        """Draw the robots at poses (n, 3) in map."""
        self._send("move", np.round(1000.0 * poses).astype(int).ravel().tolist())

    def tell(
        self, swarm: Swarm, meshes: Mapping[str, RobotMesh], robot: str, planned: Sequence[str],
        *, is_dark: bool, names: bool, tubes: bool,
    ) -> None:  # fmt: skip
        """Draw what changes more slowly: the hall, who there is, states, waits, ways, queues."""
        raster = swarm.map
        if raster is not None:
            key = id(raster), is_dark, tuple(swarm.stations), id(swarm.layout)
            if self._sent.get("still key") != key:
                self._sent["still key"] = key
                (x, y), (width, height) = raster.origin, raster.size
                stations = [
                    [name, float(place[0]), float(place[1])]
                    for name, place in swarm.stations.items()
                ]
                layout = [_flat(points) for points in swarm.layout]
                image = _url(map_image(raster, DARK if is_dark else LIGHT))
                still = {"x": x, "y": y, "width": width, "height": height, "image": image}
                self._send(
                    "setStill", still | {"isDark": is_dark, "stations": stations, "layout": layout}
                )
        robots = tuple(swarm.names), tuple(map(id, meshes.values()))
        if self._sent.get("robots key") != robots:
            self._sent["robots key"] = robots
            self._send("setCrew", _crew(swarm.names, meshes))
        place = {name: row for row, name in enumerate(swarm.names)}
        states = swarm.states
        self._send(
            "tell",
            {
                "colors": [
                    css(state_color(states[name].state)) if name in states else "#ffffff"
                    for name in swarm.names
                ],
                "waits": [
                    [place[one], place[other]]
                    for one, other in waits(states).items()
                    if one in place and other in place
                ],
                "chain": [place[name] for name in longest_chain(states) if name in place],
                "chosen": place.get(robot, -1),
                "names": names,
                "tubes": _tubes(swarm) if tubes else [],
                "ways": _ways(swarm, planned),
                "queues": _queues(states),
                "movers": [one for marker in swarm.movers if (one := _mover(marker)) is not None],
            },
        )

    def _send(self, what: str, value: Any) -> None:
        if self._sent.get(what) != value:
            self._sent[what] = value
            self._run(f"{what}({json.dumps(value, separators=(',', ':'))})")

    def _run(self, call: str) -> None:
        run_script(self._client, f"window.swarm.plan.{call}")


def waits(states: Mapping[str, ReportedState]) -> dict[str, str]:
    """Return for whom each robot waits that waits for another."""
    found = {name: waits_for(state.state, state.detail) for name, state in states.items()}
    return {name: other for name, other in found.items() if other}


def longest_chain(states: Mapping[str, ReportedState]) -> list[str]:
    """Return the longest chain of robots that wait for each other, the head last."""
    edges, best = waits(states), list[str]()
    for name in edges:
        chain = [name]
        while (after := edges.get(chain[-1], "")) and after not in chain:
            chain.append(after)
        best = max(best, chain, key=len)
    return best


def head_of_chain(robot: str, states: Mapping[str, ReportedState]) -> tuple[str, str]:
    """Return the robot that a chain of waiting leads to, and one sentence on what it does."""
    edges, chain = waits(states), [robot]
    while (after := edges.get(chain[-1], "")) and after not in chain:
        chain.append(after)
    head = chain[-1]
    state = states.get(head)
    if state is None:
        return head, f"{head} has said nothing yet."
    place = f" to {state.station}" if state.station and state.state == "driving" else ""
    detail = f": {state.detail}" if state.detail else ""
    length = f"{len(chain) - 1} robot{'s' if len(chain) > 2 else ''} behind it"
    circle = ", in a circle" if edges.get(head) in chain else ""
    return head, f"{head} is {state.state}{place}{detail}; {length}{circle}."


def _crew(names: Sequence[str], meshes: Mapping[str, RobotMesh]) -> dict[str, Any]:
    shapes: dict[int, int] = {}
    drawn: list[dict[str, Any]] = []
    kinds = []
    for name in names:
        mesh = meshes.get(name)
        if mesh is None:
            kinds.append(-1)
            continue
        if id(mesh) not in shapes:
            shapes[id(mesh)] = len(drawn)
            drawn.append(_shape(mesh))
        kinds.append(shapes[id(mesh)])
    return {"names": list(names), "shapes": drawn, "kinds": kinds}


def _shape(mesh: RobotMesh) -> dict[str, Any]:
    """Return the outline of a robot from above, and the radii around and within it [m]."""
    points = np.asarray(mesh.shape[0], np.float64)[:, :2]
    corners = points[ConvexHull(points).vertices]
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    reach = np.hypot(*(corners - middle).T)
    return {
        "corners": np.round(corners, 3).tolist(),
        "middle": np.round(middle, 3).tolist(),
        "radius": round(float(reach.max()), 3),
        "inner": round(float(0.5 * np.ptp(corners, axis=0).min()), 3),
    }


def _tubes(swarm: Swarm) -> list[list[Any]]:
    found = []
    for row, name in enumerate(swarm.names):
        _, motion = swarm.layer(name, Layer.MOTION)
        if motion is not None and len(motion.held) > 1:
            found.append([row, _flat(motion.held)])
    return found


def _ways(swarm: Swarm, planned: Sequence[str]) -> list[list[Any]]:
    found = []
    for name in planned:
        row, (_, points) = swarm.index(name), swarm.layer(name, Layer.PLAN)
        if row is not None and points is not None and len(points) > 1:
            found.append([row, _flat(points)])
    return found


def _queues(states: Mapping[str, ReportedState]) -> list[list[str]]:
    queues: dict[str, list[tuple[int, str]]] = {}
    for name, state in states.items():
        if state.station and state.queue_place > 0:
            queues.setdefault(state.station, []).append((state.queue_place, name))
    found = []
    for station, queue in queues.items():
        names = [name for _, name in sorted(queue)]
        more = f" and {len(names) - MOST_QUEUED} more" if len(names) > MOST_QUEUED else ""
        found.append([station, ", ".join(names[:MOST_QUEUED]) + more])
    return found


def _mover(marker: Any) -> dict[str, Any] | None:
    """Return the outline of a moving thing from above; None of what has none."""
    if marker.action != Marker.ADD:
        return None
    half_x, half_y = 0.5 * marker.scale.x, 0.5 * marker.scale.y
    if marker.type == Marker.CUBE:
        corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * (half_x, half_y)
    elif marker.type in (Marker.CYLINDER, Marker.SPHERE):
        angles = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
        corners = np.column_stack([half_x * np.cos(angles), half_y * np.sin(angles)])
    else:
        return None
    place, turn = marker.pose.position, marker.pose.orientation
    yaw = 2.0 * np.arctan2(turn.z, turn.w)
    cos, sin = np.cos(yaw), np.sin(yaw)
    points = corners @ np.array([[cos, sin], [-sin, cos]]) + (place.x, place.y)
    color = css(
        (round(255 * marker.color.r), round(255 * marker.color.g), round(255 * marker.color.b))
    )
    return {"name": marker.ns, "points": _flat(points), "color": color}


def _flat(points: FloatArray) -> list[int]:
    flat: list[int] = np.round(1000.0 * points).astype(int).ravel().tolist()
    return flat


def _url(image: Any) -> str:
    content = io.BytesIO()
    Image.fromarray(image).save(content, "PNG")
    return f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode()}"

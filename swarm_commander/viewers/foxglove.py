"""Foxglove layouts of a run: for one robot, and for the swarm."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

Config = dict[str, Any]
SWARM = "swarm"
COLORS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9", "#CC79A7")
SHOWN_STATES = 8  # robots whose status the layout of the swarm plots


def write_foxglove(
    folder: Path, robots: Sequence[str], newcomers: Collection[str] | None = None
) -> None:
    """Write `NAME.json` for each robot, or for newcomers only, and `swarm.json`."""
    folder.mkdir(parents=True, exist_ok=True)
    for index, robot in enumerate(robots):
        if newcomers is None or robot in newcomers:
            _write(folder / f"{robot}.json", robot_layout(robot, index))
    _write(folder / f"{SWARM}.json", swarm_layout(robots))


def _write(path: Path, layout: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(layout, indent=1) + "\n", encoding="utf-8")


def robot_layout(robot: str, index: int = 0) -> Config:
    """Return the layout for one robot: 3D view with its tools, its status, speed and waiting."""
    color = COLORS[index % len(COLORS)]
    topics = {
        **_scene_topics(),
        f"/{robot}/scan": {"visible": True, "colorMode": "flat", "flatColor": "#D55E00"},
        f"/{robot}/plan": _line(color, 0.04),
        f"/{robot}/local_plan": _line("#F0E442", 0.05),
        f"/{robot}/local_costmap/costmap": {"visible": True, "colorMode": "costmap", "alpha": 0.5},
        f"/{robot}/local_costmap/published_footprint": {"visible": True, "color": color},
        f"/{robot}/amcl_pose": {"visible": True, "type": "arrow", "color": color},
        f"/{robot}/robot_description": {"visible": True},
    }
    view = _view(
        topics,
        layers=_model(robot),
        publish={
            "type": "pose",
            "poseTopic": f"/{robot}/goal_pose",
            "poseEstimateTopic": f"/{robot}/initialpose",
        },
    )
    panels = {
        "3D!robot": view,
        "StateTransitions!robot": _states([robot]),
        "Plot!speed": _plot(
            "speed",
            {
                f"/{robot}/odom.twist.twist.linear.x": "forward [m/s]",
                f"/{robot}/odom.twist.twist.angular.z": "turning [rad/s]",
            },
        ),
        "Plot!waiting": _plot(
            "waiting",
            {
                f"/{robot}/status.hold_time": "holding [s]",
                f"/{robot}/status.wait_time": "waiting [s]",
                f"/{robot}/status.distance_remaining": "distance remaining [m]",
            },
        ),
        "RawMessages!status": {"topicPath": f"/{robot}/status", "expansion": "all"},
    }
    right = _column("RawMessages!status", _column("Plot!speed", "Plot!waiting"))
    layout = _column(_row("3D!robot", right, 68), "StateTransitions!robot", 84)
    return _whole(panels, layout)


def swarm_layout(robots: Sequence[str]) -> Config:
    """Return the layout for all robots: their true places, plans, goals and states."""
    topics = _scene_topics()
    for index, robot in enumerate(robots):
        topics[f"/{robot}/plan"] = _line(COLORS[index % len(COLORS)], 0.03)
    panels = {
        "3D!swarm": _view(topics, layers={}, publish={}),
        "StateTransitions!swarm": _states(robots[:SHOWN_STATES]),
        "Plot!goals": _plot(
            "goals reached", {f"/{name}/status.goals_reached": name for name in robots}
        ),
        "Plot!speed": _plot("real-time factor", {"/sim/verdict.real_time_factor": "factor"}),
        "RawMessages!verdict": {"topicPath": "/sim/verdict", "expansion": "all"},
    }
    right = _column("RawMessages!verdict", _column("Plot!goals", "Plot!speed"))
    layout = _column(_row("3D!swarm", right, 70), "StateTransitions!swarm", 78)
    return _whole(panels, layout)


# Parts


def _scene_topics() -> Config:
    return {
        "/map": {"visible": True, "colorMode": "map"},
        "/sim/scene": {"visible": True},
        "/sim/movers": {"visible": True},
    }


def _line(color: str, width: float) -> Config:
    return {"visible": True, "type": "line", "lineWidth": width, "gradient": [color, color]}


def _model(robot: str) -> Config:
    """Return the layer with the robot's URDF, at the frames of its own."""
    return {
        f"urdf-{robot}": {
            "layerId": "foxglove.Urdf",
            "instanceId": f"urdf-{robot}",
            "label": robot,
            "visible": True,
            "sourceType": "topic",
            "topic": f"/{robot}/robot_description",
            "framePrefix": "",
        }
    }


def _view(topics: Config, *, layers: Config, publish: Config) -> Config:
    return {
        "followMode": "follow-none",
        "followTf": "map",
        "cameraState": {
            "perspective": False,
            "distance": 24.0,
            "phi": 0.0,
            "thetaOffset": 0.0,
            "target": [0, 0, 0],
            "targetOffset": [0, 0, 0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": 45,
            "near": 0.5,
            "far": 5000,
        },
        "scene": {"transforms": {"showLabel": True, "axisScale": 0.3}},
        "transforms": {},
        "topics": topics,
        "layers": layers,
        "publish": publish,
    }


def _states(robots: Sequence[str]) -> Config:
    paths = [
        {"value": f"/{robot}/status.state", "label": robot, "timestampMethod": "receiveTime"}
        for robot in robots
    ]
    return {"paths": paths, "isSynced": True}


def _plot(title: str, values: Mapping[str, str]) -> Config:
    paths = [
        {"value": path, "label": label, "enabled": True, "timestampMethod": "receiveTime"}
        for path, label in values.items()
    ]
    return {
        "foxglovePanelTitle": title,
        "paths": paths,
        "showLegend": len(paths) <= SHOWN_STATES,
        "isSynced": True,
        "xAxisVal": "timestamp",
    }


def _row(first: object, second: object, share: float = 50.0) -> Config:
    return {"direction": "row", "first": first, "second": second, "splitPercentage": share}


def _column(first: object, second: object, share: float = 50.0) -> Config:
    return {"direction": "column", "first": first, "second": second, "splitPercentage": share}


def _whole(panels: Config, layout: Config) -> Config:
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": layout,
    }

"""Reading of layouts of fleet controls: VDMA Layout Interchange Format (LIF) 1.0 and 2.0."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import msgspec

from swarm_common.model.errors import ConfigError

LAYOUT_FILE = "layout.json"  # beside a world that was made of a layout
LARGEST = 50_000_000  # bytes of a file that is read
_OF_1 = {  # names of LIF 2.0, and what 1.0 calls the same
    "mobileRobotTypeNodeProperties": "vehicleTypeNodeProperties",
    "mobileRobotTypeEdgeProperties": "vehicleTypeEdgeProperties",
    "maximumSpeed": "maxSpeed",
}


class LayoutPosition(msgspec.Struct, frozen=True):
    """A position in a layout; stations have a heading, too."""

    x: float
    y: float
    theta: float | None = None


class NodeProperties(msgspec.Struct, frozen=True, rename="camel"):
    """Properties of a node for one type of vehicle."""

    theta: float | None = None


class LayoutNode(msgspec.Struct, frozen=True, rename="camel"):
    """A node of a layout."""

    node_id: str
    node_position: LayoutPosition
    map_id: str = ""
    vehicle_type_node_properties: tuple[NodeProperties, ...] = ()

    @property
    def pose(self) -> list[float]:
        """Return x, y, yaw as sites.yaml has them."""
        headings = [each.theta for each in self.vehicle_type_node_properties]
        yaw = next((heading for heading in headings if heading is not None), 0.0)
        return [self.node_position.x, self.node_position.y, yaw]


class EdgeProperties(msgspec.Struct, frozen=True, rename="camel"):
    """Properties of an edge for one type of vehicle."""

    max_speed: float | None = None


class LayoutEdge(msgspec.Struct, frozen=True, rename="camel"):
    """An edge of a layout, in one direction."""

    edge_id: str
    start_node_id: str
    end_node_id: str
    vehicle_type_edge_properties: tuple[EdgeProperties, ...] = ()


class LayoutStation(msgspec.Struct, frozen=True, rename="camel"):
    """A station of a layout: nodes at which vehicles work."""

    station_id: str
    interaction_node_ids: tuple[str, ...]
    station_name: str = ""
    station_position: LayoutPosition | None = None


class TrackLayout(msgspec.Struct, frozen=True, rename="camel"):
    """One layout of a file."""

    nodes: tuple[LayoutNode, ...]
    edges: tuple[LayoutEdge, ...] = ()
    stations: tuple[LayoutStation, ...] = ()
    layout_id: str = ""

    @property
    def map_id(self) -> str:
        """The map of most of its nodes; empty if they name none."""
        counts = Counter(node.map_id for node in self.nodes)
        return counts.most_common(1)[0][0] if counts else ""


def read_layout(path: Path, layout_id: str | None = None) -> tuple[TrackLayout, dict[str, Any]]:
    """Return a layout of a file, and the file with that layout alone, in the form of LIF 1.0.

    Args:
        layout_id: Of the layout; None for the only one.

    Raises:
        ConfigError: If it is none, has no node, or it has to be said which layout is meant.
    """
    try:
        data = path.read_bytes()
        if len(data) > LARGEST:
            raise ConfigError(f"{path}: {len(data)} bytes; expected at most {LARGEST}")
        content = msgspec.json.decode(data)
        found = _layouts(content)
        chosen = _chosen(path, found, layout_id)
        layout = msgspec.convert(_as_1(chosen), TrackLayout)
    except (OSError, msgspec.MsgspecError, RecursionError, TypeError) as error:
        raise ConfigError(f"{path} is no layout (LIF): {error}") from None
    if not layout.nodes:
        raise ConfigError(f"{path}: the layout '{layout.layout_id}' has no nodes")
    return layout, {"metaInformation": content.get("metaInformation", {}), "layouts": [chosen]}


def _layouts(content: Any) -> list[dict[str, Any]]:
    if not isinstance(content, dict):
        raise TypeError("expected an object")
    parts = [content, *content.get("origins", ())]
    return [layout for part in parts for layout in part.get("layouts", ())]


def _chosen(path: Path, found: list[dict[str, Any]], layout_id: str | None) -> dict[str, Any]:
    names = [str(layout.get("layoutId", "")) for layout in found]
    listed = ", ".join(f"{name:.60}" for name in names)
    if layout_id is None and len(found) != 1:
        hint = f"choose one with --layout: {listed}" if found else "expected one"
        raise ConfigError(f"{path}: {len(found)} layouts; {hint}")
    if layout_id is not None and names.count(layout_id) != 1:
        raise ConfigError(f"{path}: there is no one layout '{layout_id}'; there are {listed}")
    return found[0 if layout_id is None else names.index(layout_id)]


def _as_1(content: Any) -> Any:
    """Return a layout with the names of LIF 1.0."""
    if isinstance(content, list):
        return [_as_1(each) for each in content]
    if isinstance(content, dict):
        return {_OF_1.get(key, key): _as_1(value) for key, value in content.items()}
    return content

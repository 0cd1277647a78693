"""What the page shows of who comes and goes beside the robots."""

from types import SimpleNamespace
from typing import Any

from visualization_msgs.msg import Marker

from swarm_view.scenery import Scenery


class Handle:
    """A mesh on the page."""

    def __init__(self, shown: list["Handle"], name: str) -> None:
        self.name, self._shown = name, shown
        self.position: tuple[float, ...] = ()
        self.wxyz: tuple[float, ...] = ()
        shown.append(self)

    def remove(self) -> None:
        """Take it off the page."""
        self._shown.remove(self)


def marker(number: int, x: float, size: float = 0.4, action: int = Marker.ADD) -> Any:
    item = Marker(ns="object", id=number, type=Marker.CUBE, action=action)
    item.pose.position.x = x
    item.scale.x = item.scale.y = item.scale.z = size
    return item


def test_movers_come_move_change_and_go() -> None:
    shown: list[Handle] = []
    scene = SimpleNamespace(add_mesh_simple=lambda name, *_, **__: Handle(shown, name))
    scenery = Scenery(SimpleNamespace(scene=scene))  # type: ignore[arg-type]
    scenery.draw_movers([marker(0, 1.0), marker(1, 2.0)])
    first, second = shown
    scenery.draw_movers([marker(0, 1.5), marker(1, 2.0)])
    assert shown == [first, second]
    assert first.position[0] == 1.5
    scenery.draw_movers([marker(0, 0.0, action=Marker.DELETE), marker(1, 2.0)])
    assert shown == [second]
    scenery.draw_movers([marker(1, 2.0, size=0.8)])  # another thing of the same number
    assert len(shown) == 1
    assert shown != [second]

"""Short ways to what tests ask of a world file."""

from pathlib import Path

from swarm_describe.worlds.reader import read_world
from swarm_describe.worlds.scene import Body, Scene
from swarm_sim.scene.section import Section, section_between


def section_at(scene: Scene, height: float) -> Section:
    """Return what a horizontal plane at this height [m] cuts, movable bodies at their starts."""
    return section_between(scene.bodies, height, height)


def read_bodies(path: Path) -> list[Body]:
    return [body for body in read_world(path).bodies if body.parts]

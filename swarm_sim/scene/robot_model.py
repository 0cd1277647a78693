"""A robot's bodies as bodies of the scene."""

from __future__ import annotations

from swarm_common.robots.description import RigidGroup, RobotModel
from swarm_sim.scene.scene import Body

__all__ = ["RigidGroup", "RobotModel", "bodies_of"]


def bodies_of(model: RobotModel) -> list[Body]:
    """Return all groups of a robot as bodies in the root link's frame, joints at zero.

    Args:
        model: Groups without shapes have no body.
    """
    return [
        Body(group.name, place, group.parts, False, group.mass)
        for group, place in zip(model.groups, model.root_from_groups(), strict=True)
        if group.parts
    ]

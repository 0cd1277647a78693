"""A robot that a function of one's own drives, among robots with navigators of ours.

It drives up and down in front of a wall, by its LiDAR alone; the others keep clear of it.
"""

import numpy as np

from swarm_workbench import ExternalRobot, Sensed, Swarm, Twist


class UpAndDown:
    """Drives ahead until something is near, then turns around."""

    turning = 0

    def __call__(self, seen: Sensed) -> Twist:
        """Return the twist of a tick."""
        ahead = seen.scan.ranges[np.r_[-20:20]].min() if seen.scan else 0.0
        if self.turning == 0 and ahead > 0.7:
            return Twist(vx=0.2)
        self.turning = 40 if self.turning == 0 else self.turning - 1
        return Twist(wz=0.8)


with (
    Swarm(robots=3, drive="planar", seed=2, external=["Srobot1"]) as swarm,
    ExternalRobot("Srobot1", UpAndDown(), domain=swarm.domain),
):
    goals = [swarm["Srobot2"].go_to("loader_1"), swarm["Srobot3"].go_to("loader_2")]
    for goal in goals:
        print(goal.robot, goal.wait())
    print(f"{swarm.report.collisions} collisions, the closest {swarm.report.min_clearance:.2f} m")
    swarm.plot().figure.savefig("external_node.png", dpi=80)

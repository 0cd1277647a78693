"""Values that robots exchange."""

import math

from swarm_common.model.records import Pose, Twist


def test_a_pose_without_a_heading_equals_itself():
    """Dataclasses of Python 3.13 compare field by field, for which no NaN equals another."""
    anyhow = Pose(1.0, 2.0, math.nan)
    assert anyhow == Pose(1.0, 2.0, math.nan)
    assert anyhow != Pose(1.5, 2.0, math.nan)
    assert Pose(0.0, 0.0, 0.0) != Twist(0.0, 0.0, 0.0)
    assert (Pose(1.0, 2.0, math.nan),) == (anyhow,)

"""A robot that is driven by hand takes itself back when nobody steers it any more."""

from types import SimpleNamespace

import pytest

from swarm_common.model.records import CONTROL_PERIOD
from swarm_nav.core.goals import Goal, GoalKind
from swarm_nav.ros.nav2 import tasks
from swarm_nav.ros.nav2.tasks import STEER_LIMIT, Tasks

LATE = STEER_LIMIT + 1.0


@pytest.mark.parametrize(
    ("simulated", "wall", "allowance", "ends"),
    [
        (LATE, LATE, 0.0, True),
        (1.0, LATE, 0.0, False),  # the world was paused
        (LATE, 1.0, 0.0, False),  # it is faster than real time
        (LATE, LATE, 60.0, False),  # its client has said how long
    ],
)
def test_only_silence_of_both_clocks_ends_it(simulated, wall, allowance, ends, monkeypatch):
    reasons: list[str] = []
    served = Tasks.__new__(Tasks)
    served._services = SimpleNamespace(end_teleop=reasons.append)
    served._steered_at, served._steered_tick = 100.0, 50
    served._tick = 50 + round(simulated / CONTROL_PERIOD)
    monkeypatch.setattr(tasks.time, "monotonic", lambda: 100.0 + wall)
    served._reclaim_if_left(Goal(kind=GoalKind.TELEOP, duration=allowance))
    assert reasons == (["nobody has steered it for 20 s"] if ends else [])

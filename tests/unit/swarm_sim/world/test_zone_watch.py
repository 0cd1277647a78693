"""Ground truth about zones, by hand-made poses."""

import numpy as np

from swarm_common.model.zones import KeepoutZone, SpeedZone, Zones
from swarm_sim.world.zone_watch import ZoneWatch
from tests.fakes.navigation import waffle

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
OTHER = tuple((x + 5.0, y) for x, y in SQUARE)
ZONES = Zones(keepout=(KeepoutZone("k", SQUARE),), speed=(SpeedZone("s", OTHER, 0.1, False),))
REAR = min(x for x, _ in waffle().footprint)  # the waffle's footprint reaches farther back


def watched(*states):
    """Return the verdict on one robot's states: x, y, yaw and speed."""
    watch = ZoneWatch(ZONES)
    for tick, (x, y, yaw, speed) in enumerate(states, 1):
        poses = np.array([[x, y, yaw]])
        watch.observe(0.1 * tick, ["Srobot1"], [waffle()], poses, np.array([speed]))
    return watch.verdict


def test_the_footprint_counts_once_each_time_and_speed_at_the_centre():
    outside, touching = 2.0 - REAR + 0.01, 2.0 - REAR - 0.01
    assert watched((outside, 1.0, 0.0, 0.2)).keepout_entries == 0
    found = watched((outside, 1.0, 0.0, 0.2), (touching, 1.0, 0.0, 0.2), (touching, 1.0, 0.0, 0.0))
    assert (found.keepout_entries, found.keepout_time) == (1, 0.2)
    assert found.first == f"Srobot1 came into a keepout zone, at ({touching:.2f}, 1.00), t = 0.2 s"
    inside, outside = (1.0, 1.0, 0.0, 0.0), (4.0, 1.0, 0.0, 0.0)
    found = watched(inside, inside, outside, inside)
    assert (found.keepout_entries, found.keepout_time) == (2, 0.3)
    found = watched((4.9, 1, 0, 0.26), (5.1, 1, 0, 0.1), (5.2, 1, 0, 0.12), (5.3, 1, 0, 0.12),
                    (7.1, 1, 0, 0.26))  # fmt: skip
    assert (found.speed_violations, found.speed_violation_time) == (1, 0.2)
    assert "0.120 m/s where 0.100 are allowed" in found.first
    assert found.keepout_entries == 0

"""Slow twin of swarm_bench.runs.invariant_kernels."""

import itertools
import math

import numpy as np

from swarm_common.model.beacon import BeaconArray


def smallest(beacons: BeaconArray) -> tuple[float, float]:
    """Return the smallest gap between two robots with tubes, and the smallest less the radii."""
    gap = slack = math.inf
    for a, b in itertools.combinations(beacons, 2):
        held_a, held_b = (np.vstack((c["pose"][:2], c["held"][: c["held_size"]])) for c in (a, b))
        if a["held_size"] and b["held_size"]:
            nearest = float(np.hypot(*(held_a[:, None] - held_b[None]).T).min())
            gap = min(gap, nearest)
            slack = min(slack, nearest - float(a["radius"]) - float(b["radius"]))
    return gap, slack

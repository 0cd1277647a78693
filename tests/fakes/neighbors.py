"""The bytes of a NeighborArray message as its receivers see them."""

import numpy as np

from swarm_common.model.beacon import BEACON_DTYPE, BeaconArray


def deserialize_neighbors(data: bytes) -> tuple[int, int, BeaconArray]:
    """Return (sec, nanosec, beacons); the beacons are a view."""
    sec, nanosec, count = np.frombuffer(data, "<u4", 3, 4)
    return int(sec), int(nanosec), np.frombuffer(data, BEACON_DTYPE, int(count), 16)

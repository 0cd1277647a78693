"""Directed zones of a robot on their topic, in `std_msgs/UInt8MultiArray`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec

from swarm_common.middleware.central_io import KIND as KIND
from swarm_common.middleware.central_io import unwrapped, wrapped
from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.zones import DirectedZone

TOPIC = "directed_zones"  # of a robot
_ENCODER = msgspec.msgpack.Encoder()
_DECODER = msgspec.msgpack.Decoder(tuple[DirectedZone, ...])


def packed_zones(zones: Sequence[DirectedZone]) -> bytes:
    """Return zones as a message in CDR."""
    return wrapped(_ENCODER.encode(zones))


def read_zones(data: bytes) -> tuple[DirectedZone, ...]:
    """Return the zones that a robot is to heed from now on.

    Args:
        data: Whole message as it was taken, with its encapsulation.

    Raises:
        RejectedError: If it is none, or a zone is no polygon.
    """
    try:
        zones = _DECODER.decode(unwrapped(data))
    except msgspec.DecodeError as error:
        raise RejectedError(str(error)) from error
    for zone in zones:
        numbers = (zone.direction, zone.free_off, zone.most_off)
        corners = [number for point in zone.points for number in point]
        if len(zone.points) < 3 or not all(map(math.isfinite, (*numbers, *corners))):
            raise RejectedError(f"a directed zone is no polygon: {zone!r:.200}")
    return zones

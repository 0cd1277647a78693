"""A beacon's numpy record is its CDR body."""

import array

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from swarm_interfaces.msg import Beacon, NeighborArray

from swarm_common.model import beacon as codec
from tests.fakes.neighbors import deserialize_neighbors

ARRAYS = (
    "pose",
    "twist",
    "priority",
    "target",
    "station",
    "held",
    "wanted",
    "intent",
    "footprint",
    "heard",
    "sighted_id",
    "sighted_tick",
    "sighted_at",
)


def random_beacons(count):
    rng = np.random.default_rng(7)
    beacons = codec.empty_beacons(count)
    for name in codec.BEACON_DTYPE.names:
        field = beacons[name]
        if field.dtype.kind == "f":
            field[...] = rng.standard_normal(field.shape)
        else:
            field[...] = rng.integers(0, 1000, field.shape)
    return beacons


def assert_equal(message, record):
    assert (message.stamp.sec, message.stamp.nanosec) == (record["sec"], record["nanosec"])
    for name in codec.BEACON_DTYPE.names[2:]:
        value = getattr(message, name)
        if name in ARRAYS:
            np.testing.assert_array_equal(np.asarray(value), record[name].ravel())
        else:
            assert value == record[name]


def test_bytes_are_the_ros_message_with_every_field_in_its_place():
    record = random_beacons(1)[0]
    data = codec.serialize_beacon(record)
    message = deserialize_message(data, Beacon)
    assert_equal(message, record)
    assert serialize_message(message) == data
    assert codec.deserialize_beacon(serialize_message(message)) == record
    fields = Beacon.get_fields_and_field_types()
    assert list(fields)[1:] == list(codec.BEACON_DTYPE.names[2:])
    for name in ARRAYS:
        shape = codec.BEACON_DTYPE[name].shape
        assert f"[{int(np.prod(shape))}]" in fields[name]
    assert array.array("f").itemsize == codec.BEACON_DTYPE["held"].base.itemsize


def test_neighbors_are_joined_beacons():
    for count in (0, 1, 3):
        beacons = random_beacons(count)
        data = codec.serialize_neighbors(5, 700_000_000, beacons)
        message = deserialize_message(data, NeighborArray)
        assert (message.stamp.sec, message.stamp.nanosec) == (5, 700_000_000)
        assert len(message.beacons) == count
        for item, record in zip(message.beacons, beacons, strict=True):
            assert_equal(item, record)
        sec, nanosec, again = deserialize_neighbors(serialize_message(message))
        assert (sec, nanosec) == (5, 700_000_000)
        np.testing.assert_array_equal(again, beacons)

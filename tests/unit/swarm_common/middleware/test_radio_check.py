"""The doors of the tick's topics: any bytes become a value that makes sense, or are rejected."""

import math
import struct
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_common.middleware import cdr
from swarm_common.middleware.radio_check import read_beacon, read_neighbors
from swarm_common.middleware.rejections import RejectedError
from swarm_common.model.beacon import (
    BEACON_DTYPE,
    BEACON_SIZE,
    FLAG_LEFT,
    MOST_ID,
    SIGHTED_ASKS,
    empty_beacons,
    serialize_beacon,
    serialize_neighbors,
)
from swarm_common.model.records import Pose, Scan, Twist, stamp_from_tick
from swarm_nav.perception.absence_kernels import NOWHERE

NOW = 1234
OWN_ID = 3


def beacons(count, tick=NOW):
    batch = empty_beacons(count)
    batch["id"] = 10 + np.arange(count)
    batch["sec"], batch["nanosec"] = stamp_from_tick(tick)
    batch["tick"], batch["radius"] = tick, 0.3
    batch["held_size"], batch["footprint_size"] = 24, 4
    batch["target"] = batch["station"] = math.nan
    return batch


def scan_message():
    ranges = np.array([1.0, np.inf, np.nan], np.float32)
    return cdr.ScanWriter("base_scan", 0.2).encode(Scan(NOW, 0.0, 0.1, 0.12, 3.5, ranges))


MESSAGES: dict[str, bytes] = {
    "odom": cdr.OdometryWriter("odom", "base").encode(NOW, Pose(1.0, -2.0, 0.5), Twist(0.2)),
    "scan": scan_message(),
    "cmd_vel": cdr.CommandWriter("base").encode(NOW, Twist(0.2, 0.0, -0.1)),
    "plain cmd_vel": cdr.LITTLE_ENDIAN + struct.pack("<6d", 0.2, 0.0, 0.0, 0.0, 0.0, 1.0),
    "beacon": serialize_beacon(beacons(1)[0]),
    "neighbors": serialize_neighbors(*stamp_from_tick(NOW), beacons(5)),
}
READERS: dict[str, Callable[[bytes], object]] = {
    "odom": lambda data: cdr.OdometryReader(100.0).read(data),
    "scan": cdr.read_scan,
    "cmd_vel": lambda data: cdr.CommandReader().read(data),
    "plain cmd_vel": cdr.read_plain_command,
    "beacon": lambda data: read_beacon(data, 10, NOW),
    "neighbors": lambda data: read_neighbors(data, OWN_ID),
}
each_door = pytest.mark.parametrize("name", sorted(MESSAGES))


def check_sense(name, value):
    """Whatever a door lets in can be used without another look."""
    if name == "neighbors":
        assert isinstance(value, tuple)
        batch = value[1]
        ids = batch["id"].tolist()
        assert ids == sorted(set(ids))
        assert OWN_ID not in ids
        for beacon in batch:
            check_sense("beacon", beacon)
    elif name == "beacon":
        assert isinstance(value, np.void)
        for part in ("held", "wanted", "intent", "footprint"):
            size = int(value[f"{part}_size"])
            assert size <= len(value[part])
            assert np.isfinite(value[part][:size]).all()
        assert np.isfinite([*value["pose"], *value["twist"], value["radius"]]).all()
        assert np.isfinite(value["sighted_at"]).all()
        told = value["sighted_id"] % SIGHTED_ASKS
        assert max(value["id"], *told) <= MOST_ID  # rows are kept for each id
    elif name == "scan":
        assert isinstance(value, Scan)
        assert len(value.ranges)
        assert 0 <= value.tick < 2**31
        assert value.angle_increment
        assert math.isfinite(value.angle_min + value.angle_increment + value.range_max)
    else:
        parts = value if isinstance(value, tuple) else (value,)
        for part in parts:
            numbers = [getattr(part, "tick", 0)]
            for twist in (part, getattr(part, "twist", None)):
                if isinstance(twist, Twist):
                    numbers += [twist.vx, twist.vy, twist.wz]
            assert all(abs(number) < 2**31 for number in numbers)


def try_door(name, data):
    try:
        value = READERS[name](data)
    except RejectedError:
        return
    check_sense(name, value)


@each_door
@settings(deadline=None)  # the first beacon loads a kernel
@given(data=st.binary(max_size=3000))
def test_any_bytes_become_a_value_or_are_rejected(name, data):
    try_door(name, data)
    try_door(name, b"\x00\x01\x00\x00" + data)
    try_door(name, b"\x00\x00\x00\x00" + data)


@each_door
@settings(deadline=None)  # the first beacon loads a kernel
@given(where=st.integers(0, 4 * BEACON_SIZE), what=st.binary(min_size=1, max_size=64))
def test_a_message_with_a_few_wrong_bytes_becomes_a_value_or_is_rejected(name, where, what):
    data = bytearray(MESSAGES[name])
    where %= len(data)
    data[where : where + len(what)] = what
    try_door(name, bytes(data))


@each_door
def test_every_beginning_of_a_message_is_rejected(name):
    data = MESSAGES[name]
    needed = len(data) - (4 + 288 if name == "odom" else 4 if name == "scan" else 0)
    for size in range(0, needed - 8 * 8 if name == "odom" else needed):
        with pytest.raises(RejectedError):
            READERS[name](data[:size])


def test_a_beacon_with_more_words_than_a_beacon_has_is_rejected():
    for more in (4, 8, BEACON_SIZE):
        with pytest.raises(RejectedError, match=f"a beacon has {4 + BEACON_SIZE}"):
            READERS["beacon"](MESSAGES["beacon"] + bytes(more))


def big_endian(name):
    """Return the same message in the other byte order, which CDR allows as well."""
    data = MESSAGES[name]
    if name in ("beacon", "neighbors"):
        body = np.frombuffer(data, "<u4", offset=4).astype(">u4").tobytes()
    elif name == "plain cmd_vel":
        body = np.frombuffer(data, "<f8", offset=4).astype(">f8").tobytes()
    elif name == "scan":
        start = 4 + 8 + 4 + 12  # stamp, length and text of the frame, aligned
        body = struct.pack(">iI", *struct.unpack_from("<iI", data, 4)) + struct.pack(">I", 10)
        body += data[16:start] + np.frombuffer(data, "<u4", offset=start).astype(">u4").tobytes()
    else:
        texts = ["odom", "base"] if name == "odom" else ["base"]
        body = struct.pack(">iI", *struct.unpack_from("<iI", data, 4))
        for text in texts:
            body += bytes(-len(body) % 4) + struct.pack(">I", len(text) + 1) + text.encode() + b"\0"
        body += bytes(-len(body) % 8)
        body += np.frombuffer(data, "<f8", offset=4 + len(body)).astype(">f8").tobytes()
    return b"\x00\x00\x00\x00" + body


@each_door
def test_big_endian_messages_are_read(name):
    """They are legal CDR; at b11a34e they ended the world and every navigator."""
    little, big = READERS[name](MESSAGES[name]), READERS[name](big_endian(name))
    if isinstance(little, Scan):
        assert isinstance(big, Scan)
        np.testing.assert_array_equal(little.ranges, big.ranges)
        assert (little.tick, little.angle_min, little.range_max) == (
            big.tick, big.angle_min, big.range_max,
        )  # fmt: skip
    elif name in ("beacon", "neighbors"):
        assert repr(little) == repr(big)
    else:
        assert little == big


SIZES = ("held_size", "wanted_size", "intent_size", "footprint_size")
NUMBERS = ("radius", "pose", "twist", "held", "wanted", "intent", "footprint")


@pytest.mark.parametrize("member", SIZES)
@pytest.mark.parametrize("size", [49, 2_000_000_000, 2**32 - 1])
def test_a_beacon_with_a_size_beyond_its_capacity_is_rejected(member, size):
    """One with 2e9 points ended every process that heard it by SIGSEGV."""
    forged = beacons(3)
    forged[member][1] = size
    with pytest.raises(RejectedError, match="size"):
        read_beacon(serialize_beacon(forged[1]), 11, NOW)
    _, sound, reason = read_neighbors(serialize_neighbors(*stamp_from_tick(NOW), forged), OWN_ID)
    assert sound["id"].tolist() == [10, 12]
    assert "1 of 3 beacons" in reason


@pytest.mark.parametrize("member", NUMBERS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 3e38])
def test_a_beacon_with_an_absurd_number_is_rejected(member, value):
    forged = beacons(1)
    for size, most in zip(SIZES, (24, 8, 31, 16), strict=True):
        forged[size] = most
    flat = forged[member].reshape(1, -1)
    for place in range(flat.shape[1]):
        before = float(flat[0, place])
        flat[0, place] = value
        with pytest.raises(RejectedError, match="number"):
            read_beacon(serialize_beacon(forged[0]), 10, NOW)
        flat[0, place] = before


@pytest.mark.parametrize(
    ("member", "value", "fault"),
    [
        ("sighted_id", 2 * SIGHTED_ASKS, "id"),
        ("sighted_id", 2**32 - 1, "id"),
        ("sighted_tick", NOW + 1, "stamp"),
        ("sighted_tick", 2**32 - 1, "stamp"),
        ("sighted_at", math.nan, "number"),
        ("sighted_at", -1.1e6, "number"),
    ],
)
def test_a_beacon_with_an_absurd_sighting_is_rejected(member, value, fault):
    forged = beacons(1)
    forged[member].reshape(-1)[-1] = value
    with pytest.raises(RejectedError, match=fault):
        read_beacon(serialize_beacon(forged[0]), 10, NOW)


def test_what_a_beacon_may_hold_is_heard():
    told = beacons(1)
    word = MOST_ID | SIGHTED_ASKS
    told["sighted_id"], told["sighted_tick"], told["sighted_at"] = word, NOW, NOWHERE
    assert read_beacon(serialize_beacon(told[0]), 10, NOW)["sighted_id"][0] == word
    farewell = np.zeros(1, BEACON_DTYPE)
    farewell["id"], farewell["tick"], farewell["flags"] = 9, NOW, FLAG_LEFT
    farewell["sec"], farewell["nanosec"] = stamp_from_tick(NOW)
    batch = serialize_neighbors(*stamp_from_tick(NOW), farewell)
    assert read_neighbors(batch, OWN_ID)[1]["id"].tolist() == [9]


def test_an_id_that_is_not_its_senders_is_rejected():
    message = serialize_beacon(beacons(1)[0])
    with pytest.raises(RejectedError, match="its sender's is 4"):
        read_beacon(message, 4, NOW)
    forged = beacons(4)
    forged["id"] = (0, 7, OWN_ID, 7)  # nobody, a robot, oneself, the same robot once more
    batch = serialize_neighbors(*stamp_from_tick(NOW), forged)
    assert read_neighbors(batch, OWN_ID)[1]["id"].tolist() == [7]


@pytest.mark.parametrize("tick", [NOW + 1, 2**31, 2**32 - 1])
def test_a_beacon_of_the_future_is_rejected(tick):
    forged = beacons(1, min(tick, 2**31 - 1))
    forged["tick"] = tick
    with pytest.raises(RejectedError, match="stamp"):
        read_beacon(serialize_beacon(forged[0]), 10, NOW)


@pytest.mark.parametrize("count", [6, 2**31, 2**32 - 1])
def test_a_batch_that_claims_more_than_it_carries_is_rejected(count):
    data = bytearray(MESSAGES["neighbors"])
    struct.pack_into("<I", data, 12, count)
    with pytest.raises(RejectedError, match="too few"):
        read_neighbors(bytes(data), OWN_ID)


@pytest.mark.parametrize("stamp", [(-(2**31), 0), (2**31 - 1, 0), (1, 2**32 - 1), (-1, 0)])
@pytest.mark.parametrize("name", ["odom", "scan", "cmd_vel", "beacon", "neighbors"])
def test_a_stamp_that_no_simulated_time_has_is_rejected(name, stamp):
    data = bytearray(MESSAGES[name])
    struct.pack_into("<iI", data, 4, *stamp)
    with pytest.raises(RejectedError, match="stamp"):
        READERS[name](bytes(data))


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e308, 200.0])
@pytest.mark.parametrize("place", [0, 1])
def test_odometry_beyond_the_map_at_hand_is_rejected(value, place):
    xy = [0.0, 0.0]
    xy[place] = value
    data = cdr.OdometryWriter("odom", "base").encode(NOW, Pose(*xy, 0.0), Twist())
    with pytest.raises(RejectedError, match="position"):
        cdr.OdometryReader(100.0).read(data)


@pytest.mark.parametrize("twist", [Twist(math.nan), Twist(1e308), Twist(0.0, 0.0, math.inf)])
def test_commands_and_odometry_with_absurd_speeds_are_rejected(twist):
    with pytest.raises(RejectedError, match="twist"):
        cdr.CommandReader().read(cdr.CommandWriter("base").encode(NOW, twist))
    odometry = cdr.OdometryWriter("odom", "b").encode(NOW, Pose(0.0, 0.0, 0.0), twist)
    with pytest.raises(RejectedError, match="twist"):
        cdr.OdometryReader().read(odometry)


@pytest.mark.parametrize(
    "geometry",
    [(math.nan, 0.1, 0.1, 3.5), (0.0, 0.0, 0.1, 3.5), (0.0, math.nan, 0.1, 3.5),
     (0.0, 5.0, 0.1, 3.5), (0.0, 0.1, 3.5, 0.1), (0.0, 0.1, 0.1, math.inf)],
)  # fmt: skip
def test_a_scan_whose_geometry_makes_no_sense_is_rejected(geometry):
    """An increment of 0 divided by zero in a kernel."""
    scan = Scan(NOW, *geometry, np.ones(9, np.float32))
    with pytest.raises(RejectedError):
        cdr.read_scan(cdr.ScanWriter("base_scan", 0.2).encode(scan))


def test_a_scan_without_rays_is_rejected():
    scan = Scan(NOW, 0.0, 0.1, 0.1, 3.5, np.zeros(0, np.float32))
    with pytest.raises(RejectedError, match="0 ranges"):
        cdr.read_scan(cdr.ScanWriter("base_scan", 0.2).encode(scan))

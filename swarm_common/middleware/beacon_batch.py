"""All beacons that the robots of one host receive at a tick, as one message: each beacon once.

On one host every robot gets a message of its own, with the beacons that it hears. Between hosts
this would send each beacon once per receiver, which would be most of the traffic. A batch names who
hears which;
it is compressed, as most of a beacon's points are unused, and sealed like all that hosts say to
each other. On the wire it is a std_msgs/UInt8MultiArray.
"""

from __future__ import annotations

import hmac
import struct
import zlib
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from swarm_common.middleware.sealed import TAG, ForgedError, tag
from swarm_common.model.beacon import BEACON_SIZE, BEACON_WORDS, ENCAPSULATION, Reception

KIND = "beacons"
LEVEL = 1  # of zlib: as fast as it gets
MOST = 64 << 20  # bytes of a batch
_ARRAY = struct.Struct("<4sIII")  # CDR: no dimensions, no offset, count of bytes
_NUMBER = struct.Struct("<Q")
_HEAD = struct.Struct("<IIII")  # stamp, robots, beacons


def topic_of(host: str) -> str:
    """Return the topic of a host's batches."""
    return f"/sim/beacons/h{host}"


class BatchWriter:
    """Encodes the batches for one host."""

    def __init__(self, secret: str, run: str, host: str) -> None:
        """Begin with batch 1."""
        self._secret = secret
        self._for = (KIND.encode(), run.encode(), host.encode())
        self._number = 0

    def encode(self, sec: int, nanosec: int, receptions: Mapping[int, Reception]) -> bytes:
        """Return the message of one tick.

        Args:
            receptions: Beacons that each robot of the host hears, by its number; all share their
                words.
        """
        self._number += 1
        number = _NUMBER.pack(self._number)
        body = zlib.compress(_pack(sec, nanosec, receptions), LEVEL)
        seal = tag(self._secret, *self._for, number, body)
        data = seal + number + body
        return _ARRAY.pack(ENCAPSULATION, 0, 0, len(data)) + data


class BatchReader:
    """Decodes them, each once."""

    def __init__(self, secret: str, run: str, host: str) -> None:
        """Begin before batch 1."""
        self._secret = secret
        self._for = (KIND.encode(), run.encode(), host.encode())
        self._newest = 0

    def decode(self, message: bytes) -> list[tuple[int, bytes]]:
        """Return the NeighborArray message of each robot, by its number; none of an old batch.

        Raises:
            ForgedError: If the seal is not right.
        """
        start = _ARRAY.size
        if len(message) < start + TAG + _NUMBER.size:
            raise ForgedError(f"a batch of {len(message)} bytes")
        seal, rest = message[start : start + TAG], message[start + TAG :]
        size = _ARRAY.unpack_from(message)[3] - TAG - _NUMBER.size
        number, body = rest[: _NUMBER.size], rest[_NUMBER.size : _NUMBER.size + max(size, 0)]
        if not hmac.compare_digest(tag(self._secret, *self._for, number, body), seal):
            raise ForgedError("the seal is not that of this swarm's secret")
        count = _NUMBER.unpack(number)[0]
        if count <= self._newest:
            return []
        self._newest = count
        return list(_unpack(zlib.decompressobj().decompress(body, MOST)))


def _pack(sec: int, nanosec: int, receptions: Mapping[int, Reception]) -> bytes:
    heard = [reception.rows for reception in receptions.values()]
    used, rows = np.unique(np.concatenate(heard), return_inverse=True)
    counts = [len(each) for each in heard]
    words = next(iter(receptions.values())).words[used]
    return b"".join(
        (
            _HEAD.pack(sec, nanosec, len(counts), len(used)),
            np.array(list(receptions), "<u4").tobytes(),
            np.array(counts, "<u4").tobytes(),
            rows.astype("<u4").tobytes(),
            _by_place(words),
        )
    )


def _by_place(words: NDArray[np.uint32]) -> bytes:
    """Return the first bytes of all words, member by member, then the second ones, and so on.

    The exponents of neighbouring points are alike; so it is compressed better, and twice as fast.
    """
    parts = words.view(np.uint8).reshape(len(words), BEACON_WORDS, 4)
    return np.ascontiguousarray(parts.transpose(2, 1, 0)).tobytes()


def _unpack(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield what `_pack` packed; the seal has vouched for it."""
    sec, nanosec, robots, beacons = _HEAD.unpack_from(data)
    numbers, counts = np.frombuffer(data, "<u4", 2 * robots, _HEAD.size).reshape(2, robots)
    at = _HEAD.size + 8 * robots
    rows = np.frombuffer(data, "<u4", int(counts.sum()), at)
    planes = np.frombuffer(data, np.uint8, offset=len(data) - beacons * BEACON_SIZE)
    planes = planes.reshape(4, BEACON_WORDS, beacons)
    words = np.ascontiguousarray(planes.transpose(2, 1, 0)).view("<u4")[:, :, 0]
    start = 0
    for number, count in zip(numbers.tolist(), counts.tolist(), strict=True):
        head = np.array([sec, nanosec, count], "<u4").tobytes()
        yield number, ENCAPSULATION + head + words[rows[start : start + count]].tobytes()
        start += count

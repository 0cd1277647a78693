"""Probes of the network between two hosts: packet sizes, directions, losses, round trips.

A robots' host sends datagrams of a few sizes to the world's, which sends each back. The probes do
not depend on DDS, which goes silent without a word when large packets or one direction get lost;
so they can say why nothing is heard. They are sealed; an answer is as long as its question, so
that nobody can be flooded by means of it. `Asker` and `Answerer` have no clock and no I/O.
"""

from __future__ import annotations

import contextlib
import hmac
import math
import socket
import struct
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from swarm_common.middleware.sealed import TAG, tag

PORT = 7402  # of domain 0: within the range of DDS, by which it is unused without multicast
SMALL, WHOLE, LARGE = 200, 1472, 8000  # bytes: passes nearly everywhere; fills 1,500; fragments
SIZES = (SMALL, WHOLE, LARGE)
PERIOD, REST_PERIOD = 1.0, 5.0  # [s] between two rounds, at first and later
FIRST_ROUNDS = 30
MOST = 65536  # bytes of a datagram
LEAST = 5  # rounds before something is concluded
LEAST_FOR_SHARE = 20  # before a share is named: the first few say little of how large it is
REMEMBERED = 200  # questions of each size on which the figures are based
LOSSY = 0.04  # share of lost packets that is worth a word
SURE = 0.001  # chance at most that what is said comes of bad luck
SIGMAS = 3.09  # of the normal distribution, one-sided, for that chance
NOTHING = "nothing"
PATIENCE = 2.0  # [s] for an answer
_HEAD = struct.Struct("<IIH")  # number, answers of the smallest size heard so far, size
QUESTION, ANSWER = b"probe", b"probe answer"


def probe_port(domain: int) -> int:
    """Return the UDP port that the world's host listens on for probes."""
    return PORT + 250 * domain


@dataclass(slots=True)
class _Size:
    asked: deque[tuple[int, float, float | None]] = field(  # number, sent at, answered after [s]
        default_factory=lambda: deque(maxlen=REMEMBERED)
    )


class Asker:
    """The robots' host's side of the probes."""

    def __init__(self, secret: str, host: str) -> None:
        self._secret = secret
        self._host = host.encode()
        self._number = 0
        self._answers = 0
        self._rounds = 0
        self._due = 0.0
        self._is_answered = False
        self._sizes = {size: _Size() for size in SIZES}

    def questions(self, now: float) -> list[bytes]:
        """Return the datagrams to be sent at wall time `now`, if it is time."""
        if now < self._due:
            return []
        self._rounds += 1
        self._due = now + (PERIOD if self._rounds < FIRST_ROUNDS else REST_PERIOD)
        made = []
        for size in SIZES:
            self._number += 1
            self._sizes[size].asked.append((self._number, now, None))
            head = _HEAD.pack(self._number, self._answers, size)
            made.append(_datagram(self._secret, QUESTION, self._host, head, size))
        return made

    def take(self, data: bytes, now: float) -> None:
        """Receive an answer; foreign packets are ignored."""
        found = _open(self._secret, ANSWER, data)
        if found is None or found[0] != self._host:
            return
        number, _, size = _HEAD.unpack(found[1])
        asked = self._sizes[size].asked if size in SIZES else deque()
        for index, (known, sent_at, after) in enumerate(asked):
            if known == number and after is None:
                asked[index] = (known, sent_at, now - sent_at)
                self._answers += size == SMALL
                self._begin_with(number)
                break

    def _begin_with(self, number: int) -> None:
        """At the first answer, forget the rounds before it: nobody was there to answer them."""
        if self._is_answered:
            return
        self._is_answered = True
        first = number - (number - 1) % len(SIZES)
        for each in self._sizes.values():
            while each.asked[0][0] < first:
                each.asked.popleft()

    def restart(self) -> None:
        """Forget all measurements so far, because something has changed."""
        self._rounds, self._due, self._is_answered = 0, 0.0, False
        for each in self._sizes.values():
            each.asked.clear()

    def finding(self, now: float) -> tuple[str, str]:
        """Return the fault of the network, as far as it is known: in a word, and in a sentence.

        Both are empty if nothing is.
        """
        counts = [self._counts(size, now) for size in SIZES]
        (small, asked), (whole, _), (large, _) = counts
        if min(total for _, total in counts) < LEAST:
            return "", ""
        if small == 0:
            return NOTHING, (
                "not even small packets come back: UDP is blocked, here or there, in one direction"
                " or both, or that host is gone"
            )
        lost = 1.0 - small / asked
        is_luck = lost**asked > SURE  # larger ones may all be among the lost
        if whole == 0 and not is_luck:
            return "mtu", (
                f"packets of {SMALL} bytes come back, those of 1,500 never do: the MTU on the way"
                " is smaller; set it on both hosts (ip link set DEVICE mtu 1400)"
            )
        if large == 0 and not is_luck:
            return "fragments", (
                "packets of 1,500 bytes come back, but no fragments of larger ones: a firewall on"
                " the way drops them; let IP fragments of UDP pass"
            )
        if asked < LEAST_FOR_SHARE or lost < LOSSY or least_share(asked - small, asked) < LOSSY / 2:
            return "", ""
        return "loss", f"{lost:.0%} of the packets get lost, to there or back; the swarm is slow"

    def figures(self, now: float) -> dict[str, float]:
        """Return the figures of the report: shares of answered packets, and round trips [ms]."""
        found: dict[str, float] = {}
        for size in SIZES:
            answered, asked = self._counts(size, now)
            if asked >= LEAST:
                found[f"share_{size}_bytes"] = round(answered / asked, 4)
        times = sorted(after for _, _, after in self._sizes[SMALL].asked if after is not None)
        if times:
            found["round_trip_ms"] = round(1000.0 * times[len(times) // 2], 3)
        return found

    def _counts(self, size: int, now: float) -> tuple[int, int]:
        """Return how many questions of a size were answered, of how many that could have been."""
        ripe = [
            after
            for _, sent_at, after in self._sizes[size].asked
            if after is not None or now - sent_at > PATIENCE
        ]
        return sum(after is not None for after in ripe), len(ripe)


def least_share(lost: int, asked: int) -> float:
    """Return the lower end of Wilson's interval for a share (Wilson 1927, eq. 2 in today's form).

    Args:
        asked: Packets in all, at least one.
    """
    share, wide = lost / asked, SIGMAS**2 / asked
    spread = SIGMAS * math.sqrt(share * (1.0 - share) / asked + wide / (4 * asked))
    return (share + wide / 2 - spread) / (1.0 + wide)


class Answerer:
    """The side of the world's host."""

    def __init__(self, secret: str) -> None:
        self._secret = secret
        self._unheard: dict[bytes, tuple[int, str]] = {}  # small questions, and from where
        self._told: set[bytes] = set()

    def answer(self, data: bytes, address: str) -> bytes | None:
        """Return the answer to a datagram from an address; None if the datagram is not ours."""
        found = _open(self._secret, QUESTION, data)
        if found is None:
            return None
        host, head = found
        _, answers, size = _HEAD.unpack(head)
        if answers:
            self._unheard.pop(host, None)
        elif size == SMALL:
            self._unheard[host] = (self._unheard.get(host, (0, ""))[0] + 1, address)
        return _datagram(self._secret, ANSWER, host, head, size)

    def deaf(self) -> list[str]:
        """Return the addresses from which is asked and asked and no answer heard, each once."""
        found = {
            host: address
            for host, (count, address) in list(self._unheard.items())
            if count > LEAST and host not in self._told
        }
        self._told |= found.keys()
        return list(found.values())


def _datagram(secret: str, kind: bytes, host: bytes, head: bytes, size: int) -> bytes:
    body = bytes([len(host)]) + host + head
    body += bytes(max(0, size - TAG - len(body)))
    return tag(secret, kind, body) + body


def _open(secret: str, kind: bytes, data: bytes) -> tuple[bytes, bytes] | None:
    """Return host and head of a datagram of a given kind; None if the datagram is invalid."""
    seal, body = data[:TAG], data[TAG:]
    if (
        not body
        or len(body) < 1 + body[0] + _HEAD.size
        or not hmac.compare_digest(tag(secret, kind, body), seal)
    ):
        return None
    at = 1 + body[0]
    head = body[at : at + _HEAD.size]
    return (body[1:at], head) if _HEAD.unpack(head)[2] == len(data) else None


class ProbeSocket:
    """The UDP socket of either side, and a thread that passes datagrams on at once."""

    def __init__(
        self, address: str, domain: int, take: Callable[[bytes, str], bytes | None]
    ) -> None:
        """Listen; if the port is in use, no datagram ever arrives.

        Args:
            take: Called in the thread with datagram and sender; what it returns is sent back.
        """
        self._port = probe_port(domain)
        self._take = take
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((address, self._port))
        except OSError:
            return
        threading.Thread(target=self._listen, daemon=True).start()

    def send(self, data: bytes, address: str) -> None:
        """Send a datagram; a network that is down takes none."""
        with contextlib.suppress(OSError):
            self._socket.sendto(data, (address, self._port))

    def _listen(self) -> None:
        while True:
            try:
                data, (address, port) = self._socket.recvfrom(MOST)
            except OSError:  # the kernel's answer that no process listens there
                continue
            answer = self._take(data, address)
            if answer is not None and port == self._port:
                self.send(answer, address)

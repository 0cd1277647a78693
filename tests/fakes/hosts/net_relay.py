"""A switch between hosts that delays, reorders, drops and narrows: what `tc netem` does elsewhere.

Kernels without netem exist. Each host's eth0 is a TAP device whose other end is this process:
python tests/fakes/hosts/net_relay.py NAMESPACE... ; qualities come as JSON lines on its standard
input, `{"from": 1, "to": 2, "loss": 0.01}`, without `from` or `to` for all hosts.
"""

import ctypes
import fcntl
import heapq
import json
import os
import random
import selectors
import struct
import sys
import time
from dataclasses import dataclass, field, replace
from pathlib import Path

TUNSETIFF, IFF_TAP, IFF_NO_PI = 0x400454CA, 0x0002, 0x1000
CLONE_NEWNET = 0x40000000
MOST = 65536
HEAD, IP = 14, b"\x08\x00"  # bytes of an Ethernet head, and the type in it


@dataclass(frozen=True)
class Quality:
    """Of the way from one host to another."""

    delay: float = 0.0  # [s]
    jitter: float = 0.0  # [s] up to which the delay is more or less, each packet on its own
    loss: float = 0.0  # share of the packets, a fragment being one
    rate: float = 0.0  # [bit/s] in front of the delay; 0 for no limit
    queue: float = 0.1  # [s] of it that wait; more are dropped
    largest: int = 1500  # [bytes] of an IP packet; larger ones vanish without a word


@dataclass
class Port:
    """One host's end."""

    fd: int
    free_at: dict[int, float] = field(default_factory=dict)  # by the host that it sends to


class Relay:
    """Passes frames on."""

    def __init__(self, namespaces: list[str], seed: int = 0) -> None:
        self._ports = [Port(_tap(name)) for name in namespaces]
        self._quality = {
            (a, b): Quality() for a in range(len(namespaces)) for b in range(len(namespaces))
        }
        self._where: dict[bytes, int] = {}
        self._due: list[tuple[float, int, int, bytes]] = []
        self._count = 0
        self._random = random.Random(seed)
        self._sent = self._lost = self._bytes = 0

    def set(self, **values: float) -> None:
        """Change the quality of some ways."""
        start, end = values.pop("from", 0), values.pop("to", 0)
        for way, quality in self._quality.items():
            if start in (0, way[0] + 1) and end in (0, way[1] + 1):
                self._quality[way] = replace(quality, **values)

    def run(self) -> None:
        """Pass frames on until standard input ends."""
        selector = selectors.DefaultSelector()
        for number, port in enumerate(self._ports):
            os.set_blocking(port.fd, False)
            selector.register(port.fd, selectors.EVENT_READ, number)
        selector.register(sys.stdin, selectors.EVENT_READ, -1)
        while True:
            wait = self._due[0][0] - time.monotonic() if self._due else None
            for key, _ in selector.select(None if wait is None else max(0.0, wait)):
                if key.data >= 0:
                    self._read(key.data)
                    continue
                line = sys.stdin.readline()
                if not line:
                    return
                values = json.loads(line)
                if values:
                    self.set(**values)
                state = {"sent": self._sent, "lost": self._lost, "bytes": self._bytes}
                print(json.dumps(state), flush=True)  # noqa: T201
            self._deliver()

    def _read(self, source: int) -> None:
        for _ in range(64):
            try:
                frame = os.read(self._ports[source].fd, MOST)
            except BlockingIOError:
                return
            self._where[frame[6:12]] = source
            target = self._where.get(frame[:6])
            others = [n for n in range(len(self._ports)) if n != source]
            for each in others if target is None else [target]:
                self._take(source, each, frame)

    def _take(self, source: int, target: int, frame: bytes) -> None:
        quality, now = self._quality[source, target], time.monotonic()
        self._sent += 1
        self._bytes += len(frame)
        is_ip = frame[12:14] == IP  # who blocks a direction lets ARP pass
        is_lost = is_ip and self._random.random() < quality.loss
        is_lost = is_lost or len(frame) - HEAD > quality.largest
        if quality.rate and not is_lost:
            ports = self._ports[source].free_at
            free_at = max(now, ports.get(target, 0.0))
            is_lost = free_at - now > quality.queue
            if not is_lost:
                now = ports[target] = free_at + 8 * len(frame) / quality.rate
        if is_lost:
            self._lost += 1
            return
        wait = quality.delay + quality.jitter * (2.0 * self._random.random() - 1.0)
        self._count += 1
        heapq.heappush(self._due, (now + max(0.0, wait), self._count, target, frame))

    def _deliver(self) -> None:
        now = time.monotonic()
        while self._due and self._due[0][0] <= now:
            _, _, target, frame = heapq.heappop(self._due)
            try:
                os.write(self._ports[target].fd, frame)
            except OSError:  # its queue is full, or the device is down
                self._lost += 1


def _tap(namespace: str) -> int:
    """Return the other end of eth0 in a network namespace."""
    libc = ctypes.CDLL(None, use_errno=True)
    with Path("/proc/self/ns/net").open() as own, Path(f"/run/netns/{namespace}").open() as other:
        if libc.setns(other.fileno(), CLONE_NEWNET):
            raise OSError(ctypes.get_errno(), "setns")
        try:
            fd = os.open("/dev/net/tun", os.O_RDWR)
            fcntl.ioctl(fd, TUNSETIFF, struct.pack("16sH22x", b"eth0", IFF_TAP | IFF_NO_PI))
        finally:
            libc.setns(own.fileno(), CLONE_NEWNET)
    return fd


def main() -> None:
    relay = Relay(sys.argv[1:])
    print("{}", flush=True)  # noqa: T201
    relay.run()


if __name__ == "__main__":
    main()

"""Hosts on this machine: network namespaces on one switch; no way leads out of it."""

from __future__ import annotations

import json
import os
import socket
import struct
import subprocess
import sys
from pathlib import Path
from types import TracebackType

import pytest

RELAY = Path(__file__).with_name("net_relay.py")


class NetHosts:
    """Hosts 10.213.0.1, 10.213.0.2, ...; all that was made goes when it is left."""

    def __init__(self, count: int, *, with_relay: bool = False) -> None:
        """Prepare; with a relay the network has a quality, see `set_quality`."""
        self.count = count
        self._with_relay = with_relay
        self._relay: subprocess.Popen[str] | None = None
        self._mark = f"sw{os.getpid()}"
        self._switch = f"{self._mark}s"

    def __enter__(self) -> NetHosts:
        try:
            if self._with_relay:
                self._join_by_relay()
            else:
                self._join_by_bridge()
        except subprocess.CalledProcessError as error:
            self._remove()
            pytest.skip(f"no network namespaces can be made here: {error.stderr.strip()}")
        except OSError as error:
            pytest.skip(f"no network namespaces can be made here: {error}")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._remove()

    def name(self, host: int) -> str:
        return f"{self._mark}h{host}"

    def address(self, host: int) -> str:
        return f"10.213.0.{host}"

    def command(self, host: int, *command: str) -> tuple[str, ...]:
        return ("ip", "netns", "exec", self.name(host), *command)

    def set_link(self, host: int, state: str) -> None:
        """Switch a host's only link `up` or `down`."""
        self._in(self.name(host), "link", "set", "eth0", state)

    def pids(self) -> list[int]:
        return [pid for host in range(1, self.count + 1) for pid in self.pids_on(host)]

    def pids_on(self, host: int) -> list[int]:
        return [int(word) for word in _ip("netns", "pids", self.name(host)).split()]

    def bound_addresses(self, host: int) -> set[str]:
        rows = _ip("netns", "exec", self.name(host), "cat", "/proc/net/udp").splitlines()[1:]
        words = [int(row.split()[1].split(":")[0], 16) for row in rows]
        return {socket.inet_ntoa(struct.pack("=I", word)) for word in words}

    def set_quality(self, **values: float) -> dict[str, int]:
        """Change the quality of the relay's ways, see `net_relay.Quality`; return what passed."""
        self._relay.stdin.write(json.dumps(values) + "\n")
        self._relay.stdin.flush()
        passed: dict[str, int] = json.loads(self._relay.stdout.readline())
        return passed

    def _join_by_bridge(self) -> None:
        self._make(self._switch)
        self._in(self._switch, "link", "add", "br0", "type", "bridge")
        self._in(self._switch, "link", "set", "br0", "up")
        for host in range(1, self.count + 1):
            self._plug_in(host)

    def _join_by_relay(self) -> None:
        names = [self.name(host) for host in range(1, self.count + 1)]
        for name in names:
            self._make(name)
        command = (sys.executable, str(RELAY), *names)
        pipe = subprocess.PIPE
        self._relay = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)
        if not self._relay.stdout.readline():
            raise OSError("no TAP devices")
        for host, name in enumerate(names, 1):
            self._in(name, "link", "set", "eth0", "txqueuelen", "10000")
            self._in(name, "addr", "add", f"{self.address(host)}/24", "dev", "eth0")
            self._in(name, "link", "set", "eth0", "up")

    def _plug_in(self, host: int) -> None:
        name, port = self.name(host), f"p{host}"
        self._make(name)
        peer = ("peer", "name", "eth0", "netns", name)
        self._in(self._switch, "link", "add", port, "type", "veth", *peer)
        self._in(self._switch, "link", "set", port, "master", "br0", "up")
        self._in(name, "addr", "add", f"{self.address(host)}/24", "dev", "eth0")
        self._in(name, "link", "set", "eth0", "up")

    def _make(self, name: str) -> None:
        _ip("netns", "add", name)
        self._in(name, "link", "set", "lo", "up")

    def _in(self, name: str, *words: str) -> None:
        _ip("-n", name, *words)

    def _remove(self) -> None:
        if self._relay is not None:
            self._relay.kill()
            self._relay.communicate()
        names = [self.name(host) for host in range(1, self.count + 1)]
        for name in (*names, self._switch):
            subprocess.run(("ip", "netns", "del", name), capture_output=True, check=False)


def _ip(*words: str) -> str:
    done = subprocess.run(("ip", *words), capture_output=True, text=True, check=True)
    return done.stdout

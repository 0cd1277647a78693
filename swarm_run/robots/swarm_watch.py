"""Whether a swarm has a ROS domain: how long one that starts is awaited, whether one has ended."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from swarm_common.middleware import ros_env
from swarm_common.model.errors import ConfigError, NoSwarmError, SwarmEndedError

LOOK_LIMIT = 5.0  # [s] of wall time to see a swarm of which nothing is known
START_LIMIT = 300.0  # [s] of wall time for a swarm that starts; its code may be compiled first
TELL_AFTER = 3.0  # [s] of waiting in silence
SOCKETS = Path("/proc/net/unix")  # lists the sockets of this host, see proc_net_unix(5)
PERIOD = 1.0  # [s] of wall time between two looks
GONE_TIME = 5.0  # [s] of wall time without a world after which a swarm on other hosts has ended


def domain_address(domain: int) -> str:
    """Return the abstract socket that the process which owns a domain's swarm listens on.

    Returns:
        Its name with the leading NUL of Linux, see unix(7).
    """
    return f"\0swarm-up-domain-{domain}"


def has_swarm(domain: int) -> bool | None:
    """Return whether a swarm runs or starts in the domain; None if unknown.

    If the graph is limited to this host, a process here holds the domain of a swarm. A swarm on
    another host cannot be seen.
    """
    if ros_env.bound_address() != ros_env.LOOPBACK:
        return None
    name = f"@{domain_address(domain)[1:]}"
    return name in SOCKETS.read_text(encoding="utf-8", errors="replace").split()


class SwarmWatch:
    """Notices that the swarm of a node's domain has ended, however it ended.

    Where the domain's owner cannot be seen, its clock counts: a swarm without one has ended.

    Attributes:
        has_ended: Whether a swarm was seen, and is gone.
    """

    def __init__(self, node: Any) -> None:
        """Begin to watch, with a first look.

        Args:
            node: `rclpy.node.Node` in the ROS domain of the swarm; it is not spun. Its type is
                not imported: who only looks whether there is a swarm needs no ROS.
        """
        self.has_ended = False
        self._node = node
        self._was_there = False
        self._due = 0.0
        self._seen_at = 0.0
        self.look()

    def look(self, now: float | None = None) -> bool:
        """Look if it is time to; return whether the swarm has ended.

        Args:
            now: Wall time [s]; by default that of the clock.
        """
        now = time.monotonic() if now is None else now
        if now >= self._due and not self.has_ended:
            self._due = now + PERIOD
            if self._is_there(now):
                self._was_there = True
            else:
                self.has_ended = self._was_there
        return self.has_ended

    def check(self) -> None:
        """Look if it is time to.

        Raises:
            SwarmEndedError: If the swarm has ended.
        """
        if self.look():
            raise SwarmEndedError

    def _is_there(self, now: float) -> bool:
        known = has_swarm(self._node.context.get_domain_id())
        if known is not None:
            return known
        if self._node.count_publishers("/clock"):
            self._seen_at = now
        return bool(self._seen_at) and now - self._seen_at < GONE_TIME


class SwarmPatience:
    """Waits for a swarm that is not seen yet while one starts, and no longer."""

    def __init__(
        self,
        domain: int,
        has_swarm: Callable[[], bool | None],
        tell: Callable[[str], None],
        limit: float = LOOK_LIMIT,
    ) -> None:
        """Begin with nothing said.

        Args:
            has_swarm: Says whether somebody has it; None if that cannot be known.
            limit: [s] of wall time where it cannot be known.
        """
        self._domain, self._has_swarm, self._tell, self._limit = domain, has_swarm, tell, limit
        self._is_told = False

    def check(self, waited: float) -> None:
        """Say once what is waited for.

        Args:
            waited: [s] of wall time so far.

        Raises:
            NoSwarmError: If there is no swarm to wait for.
            ConfigError: If one starts that does not come up.
        """
        known = self._has_swarm()
        if known is False or (known is None and waited > self._limit):
            raise NoSwarmError(self._domain)
        if waited > START_LIMIT:
            raise ConfigError(
                f"the swarm in ROS domain {self._domain} has not come up within"
                f" {START_LIMIT:.0f} s; see what its swarm-up says"
            )
        if known and waited > TELL_AFTER and not self._is_told:
            self._tell(f"the swarm in ROS domain {self._domain} is starting; waiting for it")
            self._is_told = True

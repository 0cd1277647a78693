"""ROS domains that no other run of the tests on this machine uses."""

import contextlib
import itertools
import os
import socket
from collections.abc import Iterable, Iterator

RUNS = range(89, 102)  # one for each run of the tests
SWARMS = range(40, 88, 2)  # for swarms within a run; the next one is for a second swarm
_turns = itertools.count()


def reserve(domains: Iterable[int], reservation: socket.socket) -> int | None:
    """Return a domain that is ours while a (new) socket is open; None if all are in use."""
    for domain in domains:
        with contextlib.suppress(OSError):
            reservation.bind(f"\0swarm-graph-test-{domain}")
            return domain
    return None


def unix_socket() -> socket.socket:
    return socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)


def of_this_run(reservation: socket.socket) -> int:
    """Return the domain of this run of the tests: two runs must not see each other."""
    return reserve(RUNS, reservation) or 20 + os.getpid() % 20


@contextlib.contextmanager
def reserved_domain() -> Iterator[int]:
    """Yield a ROS domain that no other run of the tests uses, and this one did not use lately.

    Nodes may live on for a while after a test, until Python or DDS has forgotten them.
    """
    turns = (SWARMS[next(_turns) % len(SWARMS)] for _ in SWARMS)
    with unix_socket() as reservation:
        domain = reserve(turns, reservation)
        assert domain is not None, "every ROS domain for tests is in use"
        yield domain

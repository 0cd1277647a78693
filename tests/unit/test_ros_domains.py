"""The domains of the graph tests: none comes back while nodes of its last test may live on."""

import os
import subprocess

from tests.fakes.real_swarm import is_test
from tests.fakes.ros_domains import SWARMS, reserved_domain


def test_a_domain_does_not_come_back_before_most_others_had_their_turn():
    used = []
    with reserved_domain():  # others' runs have some, too
        for _ in range(3 * len(SWARMS)):
            with reserved_domain() as domain:
                assert domain not in used[-len(SWARMS) // 2 :]
                used.append(domain)


def test_no_two_have_a_domain_at_once():
    with reserved_domain() as first, reserved_domain() as second:
        assert first != second


def test_ports_of_other_tests_are_told_from_those_of_a_swarm():
    """A node of another run of tests lived on in a domain, and a swarm had left its ports there."""
    with subprocess.Popen(("sleep", "60")) as swarm:
        assert (is_test(os.getpid()), is_test(swarm.pid), is_test(None)) == (True, False, False)
        swarm.kill()

"""The domains of the graph tests: none comes back while nodes of its last test may live on."""

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

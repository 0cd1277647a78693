"""Who is waited for before a tick begins, and for how long."""

from swarm_mission.orders.order_barrier import PATIENCE, START_PATIENCE, OrderBarrier


def test_a_tick_begins_when_all_have_spoken_in_the_one_before():
    barrier = OrderBarrier(["station", "courier"])
    assert barrier.is_complete(-1, 0.0)
    assert not barrier.is_complete(0, 0.0)
    assert barrier.hear("station", 0, is_in_step=False)
    assert barrier.missing(0) == ["courier"]
    assert barrier.is_complete(0, 0.0, ["station"])
    barrier.hear("courier", 0, is_in_step=True)
    assert barrier.is_complete(0, 0.0)


def test_no_party_runs_ahead_of_the_world():
    barrier = OrderBarrier(["station", "courier"])
    barrier.hear("station", 0, is_in_step=False)
    barrier.hear("courier", 0, is_in_step=False)  # its robots are down
    assert not barrier.is_due(1)
    barrier.see(1)
    assert barrier.is_due(1)
    barrier.hear("courier", 1, is_in_step=True)
    assert barrier.is_due(2)


def test_who_is_silent_is_left_out_once_the_world_has_gone_on_and_until_it_speaks_again():
    barrier = OrderBarrier(["courier"])
    barrier.hear("courier", 3, is_in_step=True)
    assert not barrier.is_complete(4, 0.0)
    assert not barrier.is_complete(4, 2 * PATIENCE)  # the world is paused
    barrier.see(5)
    assert not barrier.is_complete(4, 2 * PATIENCE)
    assert barrier.is_complete(4, 3.1 * PATIENCE)
    assert barrier.is_complete(5, 3.1 * PATIENCE)
    barrier.hear("courier", 5, is_in_step=True)
    assert barrier.missing(6) == ["courier"]


def test_a_party_may_start_late_and_its_word_counts_once():
    barrier = OrderBarrier(["courier"])
    barrier.see(5)
    assert not barrier.is_complete(0, 0.0)
    assert not barrier.is_complete(0, START_PATIENCE)
    assert barrier.is_complete(0, START_PATIENCE + 1.0)
    barrier = OrderBarrier(["courier"])
    assert not barrier.accepts("courier", 1)  # the first was lost: both are repeated
    assert barrier.accepts("courier", 0)
    barrier.hear("courier", 0, is_in_step=True)
    assert not barrier.accepts("courier", 0)
    assert barrier.accepts("courier", 1)
    assert not barrier.accepts("courier", 2)
    assert barrier.accepts("courier", 3)  # what it said before is not repeated any more
    assert barrier.accepts("an outsider", 0)

from swarm_sim.ros.robots.barrier import NEWCOMER_LIMIT, Barrier


def complete(barrier, begin, end):
    for step in range(int(end - begin)):
        barrier.is_complete(begin + step)
    return barrier.is_complete(end)


def test_the_time_in_which_the_world_slept_does_not_count_nor_a_held_barrier():
    """After SIGSTOP and SIGCONT of all processes, robots were "late" that had slept as well."""
    barrier = started()
    barrier.record_silence(1, since=9.0)
    barrier.open(10.0)
    barrier.answer(0)
    assert not complete(barrier, 10.0, 12.0)
    assert not barrier.is_complete(72.0)
    assert not complete(barrier, 72.0, 73.9)
    assert barrier.receive_late() == []
    assert not complete(barrier, 73.9, 74.5)
    assert barrier.receive_late() == [(1, False)]
    assert complete(barrier, 74.5, 75.1)
    assert barrier.receive_late() == [(2, True)]
    # Time began before those who were to record it could.
    barrier = Barrier(1, 5.0)
    barrier.is_held = True
    barrier.open(0.0)
    barrier.answer(0)
    assert not complete(barrier, 0.0, 60.0)
    barrier.is_held = False
    assert barrier.is_complete(60.0)


def test_who_is_late_is_told_once():
    barrier = Barrier(2, 5.0)
    for robot in (0, 1):
        barrier.answer(robot)
    barrier.open(0.0)
    barrier.answer(0)
    assert not barrier.is_complete(4.0)
    assert barrier.receive_late() == []
    barrier.close()
    barrier.open(10.0)
    barrier.answer(0)
    assert complete(barrier, 10.0, 16.0)
    assert barrier.receive_late() == [(1, True)]
    assert barrier.receive_late() == []


def test_where_most_are_late_it_may_be_the_machine():
    barrier = started(3)
    barrier.open(10.0)
    barrier.answer(0)
    assert complete(barrier, 10.0, 16.0)
    assert barrier.receive_late() == [(1, False), (2, False)]


def started(count=3):
    barrier = Barrier(count, 5.0)
    barrier.open(0.0)
    for robot in range(count):
        barrier.answer(robot)
    barrier.close()
    return barrier


def test_at_the_start_all_are_waited_for_without_limit():
    barrier = Barrier(2, 5.0)
    barrier.open(0.0)
    barrier.answer(1)
    assert not barrier.is_complete(1000.0)
    barrier.answer(0)
    assert barrier.is_complete(1000.0)
    assert not barrier.has_started
    barrier.close()
    assert barrier.has_started
    assert barrier.late_ticks == 0


def test_a_late_robot_is_not_waited_for_until_it_answers_again():
    barrier = started()
    barrier.open(10.0)
    barrier.answer(0)
    barrier.answer(2)
    assert not barrier.is_complete(14.9)
    assert list(barrier.missing()) == [1]
    assert barrier.is_complete(15.1)
    barrier.close()
    assert (barrier.late_ticks, barrier.answering) == (1, 2)
    barrier.open(15.1)
    barrier.answer(0)
    barrier.answer(2)
    assert barrier.is_complete(15.1)
    barrier.answer(1)
    barrier.close()
    assert (barrier.late_ticks, barrier.answering) == (1, 3)


def test_a_dead_robot_is_not_waited_for_also_before_the_start():
    barrier = started()
    barrier.open(10.0)
    barrier.lose(1)
    barrier.answer(0)
    barrier.answer(2)
    assert barrier.is_complete(10.0)
    barrier.close()
    assert barrier.late_ticks == 0
    barrier = Barrier(2, 5.0)
    barrier.open(0.0)
    barrier.answer(0)
    barrier.lose(1)
    assert barrier.is_complete(0.0)


def test_free_run_waits_for_nobody():
    barrier = Barrier(2, 5.0, expects=False)
    barrier.open(0.0)
    assert barrier.is_complete(0.0)
    barrier.close()
    assert barrier.late_ticks == 0
    barrier = Barrier(2, 5.0, expects=False)
    barrier.open(0.0)
    barrier.answer(1)
    barrier.close()
    assert barrier.answering == 1
    barrier.open(0.1)
    assert list(barrier.missing()) == []
    assert barrier.is_complete(0.1)
    barrier.close()
    assert (barrier.late_ticks, barrier.answering) == (0, 0)


def test_a_newcomer_is_waited_for_with_patience_and_not_late():
    barrier = Barrier(1, 15.0)
    barrier.open(0.0)
    barrier.answer(0)
    barrier.close()
    barrier.add()
    barrier.open(1.0)
    barrier.answer(0)
    assert barrier.missing() == [1]
    assert not complete(barrier, 1.0, 1.0 + NEWCOMER_LIMIT - 0.1)
    assert barrier.is_complete(1.0 + NEWCOMER_LIMIT + 0.1)
    barrier.close()
    assert barrier.late_ticks == 0
    barrier.open(40.0)
    barrier.answer(0)
    barrier.answer(1)  # there at last
    barrier.close()
    barrier.open(41.0)
    barrier.answer(0)
    assert not complete(barrier, 41.0, 41.0 + 14.9)
    assert barrier.is_complete(41.0 + 15.1)
    barrier.close()
    assert barrier.late_ticks == 1


def test_who_was_taken_out_is_not_waited_for_until_it_is_welcome_again():
    barrier = Barrier(2, 15.0)
    barrier.lose(1)
    barrier.open(0.0)
    barrier.answer(0)
    assert barrier.is_complete(0.0)
    barrier.close()
    assert barrier.answering == 1
    barrier.welcome(1)
    barrier.open(1.0)
    barrier.answer(0)
    assert barrier.missing() == [1]


def test_a_late_robot_that_keeps_up_is_waited_for_again_unless_it_is_dead():
    barrier = started()
    barrier.open(10.0)
    assert complete(barrier, 10.0, 15.1)
    barrier.hear(1)
    assert list(barrier.missing()) == [1]
    barrier.lose(1)
    barrier.hear(1)
    assert list(barrier.missing()) == []


def test_silence_of_a_host_is_waited_for_once_and_not_anew_in_each_tick():
    barrier = started()
    barrier.record_silence(0, since=10.0)
    barrier.record_silence(1, since=10.0)
    barrier.open(13.0)
    barrier.answer(1)  # was under way
    barrier.answer(2)
    assert not barrier.is_complete(14.9)
    assert barrier.is_complete(15.1)
    barrier.close()
    barrier.open(15.1)
    barrier.answer(2)
    assert barrier.is_complete(15.2)
    barrier.close()
    barrier.end_silence(1)
    barrier.open(15.3)
    barrier.answer(1)
    barrier.answer(2)
    assert barrier.is_complete(15.3)
    barrier.close()
    barrier.open(15.4)
    barrier.answer(2)
    assert not barrier.is_complete(20.3)

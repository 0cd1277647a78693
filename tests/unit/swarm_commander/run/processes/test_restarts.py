from swarm_commander.run.processes.restarts import MOST, Restarts


def test_a_dead_process_is_started_anew_after_a_pause_if_somebody_wants_it():
    restarts = Restarts()
    assert restarts.on_death("Srobot1", 10.0) == 1.0
    assert restarts.pop_due(10.9) == []
    assert restarts.pop_due(11.0) == ["Srobot1"]
    assert restarts.pop_due(12.0) == []
    assert restarts.total == 1
    restarts = Restarts(is_allowed=False)
    assert restarts.on_death("Srobot1", 0.0) is None
    restarts.on_request("Srobot1", 1.0)
    assert restarts.pop_due(1.0) == ["Srobot1"], "but its user may"
    restarts = Restarts()
    restarts.on_death("Srobot1", 0.0)
    restarts.forget("Srobot1")
    assert restarts.pop_due(100.0) == []


def test_pauses_double_and_after_five_times_it_stays_down():
    restarts, now, pauses = Restarts(), 0.0, []
    while (pause := restarts.on_death("Srobot1", now)) is not None:
        pauses.append(pause)
        now += pause
        assert restarts.pop_due(now) == ["Srobot1"]
    assert pauses == [1.0, 2.0, 4.0, 8.0, 16.0]
    assert len(pauses) == MOST
    assert restarts.on_death("Srobot2", now) == 1.0, "each has its own count"

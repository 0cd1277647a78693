from swarm_sim.ros.services.run_state import Answer, RunState


def test_pause_and_play():
    state = RunState()
    assert not state.is_held
    assert state.play() is Answer.ALREADY
    assert state.pause() is Answer.DONE
    assert state.is_held
    assert state.pause() is Answer.ALREADY
    assert state.play() is Answer.DONE
    assert not state.is_held


def test_steps_are_answered_once_and_by_playing():
    state = RunState()
    done: list[int] = []
    assert state.step(1, lambda _: done.append(0)) is Answer.REFUSED
    state.pause()
    assert state.step(0, lambda _: done.append(0)) is Answer.REFUSED
    assert state.step(2, lambda _: done.append(2)) is Answer.DONE
    state.record_tick()
    assert not state.is_held
    assert not done
    state.record_tick()
    assert state.is_held
    assert done == [2]
    state.record_tick()
    assert done == [2]
    state = RunState()
    done: list[int] = []
    state.pause()
    state.step(5, lambda _: done.append(5))
    state.play()
    assert done == [5]
    state.pause()
    assert state.is_held


def test_steps_tell_of_each_tick_and_of_their_end_before_its_time():
    state = RunState()
    ticks: list[int] = []
    done: list[bool] = []
    state.pause()
    state.step(3, done.append, lambda: ticks.append(1))
    state.record_tick()
    state.cancel_steps()
    assert (len(ticks), done, state.is_held) == (1, [False], True)

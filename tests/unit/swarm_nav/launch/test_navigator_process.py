from swarm_common.process.lifetime import LEASE, SleepWatch
from swarm_nav.launch.navigator_process import QUEUED, REUNION, StopWatch


class Clock:
    def __init__(self):
        self.time = 100.0

    def __call__(self):
        return self.time


def _watch(clock):
    return StopWatch(SleepWatch(LEASE, clock, lambda: 0.0), clock)


def _forgotten_after(clock, watch, ticked_at):
    """Return how long [s] after now the process ends; None: not within a minute."""
    start = clock.time
    for _ in range(240):
        if watch.is_forgotten(ticked_at):
            return clock.time - start
        clock.time += 0.25
    return None


def test_a_navigator_that_nobody_knows_any_more_after_a_stop_ends():
    clock = Clock()
    watch = _watch(clock)
    clock.time += LEASE + 10.0
    after = _forgotten_after(clock, watch, ticked_at=100.0)
    assert after is not None
    assert REUNION < after <= REUNION + 0.5


def test_one_that_gets_ticks_again_or_was_not_stopped_goes_on():
    clock = Clock()
    watch = _watch(clock)
    clock.time += LEASE + 10.0
    assert not watch.is_forgotten(ticked_at=100.0)
    assert _forgotten_after(clock, watch, ticked_at=clock.time + QUEUED + 1.0) is None
    assert _forgotten_after(clock, watch, ticked_at=clock.time) is None
    clock = Clock()
    assert _forgotten_after(clock, _watch(clock), ticked_at=0.0) is None
    clock = Clock()
    watch = _watch(clock)
    clock.time += LEASE + 10.0
    assert _forgotten_after(clock, watch, ticked_at=clock.time + 1.0) is not None

"""Whether a process was stopped for a while."""

from swarm_common.process.lifetime import SleepWatch


def test_who_was_stopped_has_slept_and_who_worked_or_waited_often_has_not():
    now = {"clock": 100.0, "computed": 5.0}
    watch = SleepWatch(10.0, lambda: now["clock"], lambda: now["computed"])
    for passed, computed, slept in (
        (0.25, 0.1, 0.0),
        (10.0, 0.0, 0.0),
        (40.0, 0.1, 40.0),
        (0.25, 0.1, 0.0),
        (40.0, 30.0, 0.0),  # it was busy
    ):
        now["clock"] += passed
        now["computed"] += computed
        assert watch.slept() == slept

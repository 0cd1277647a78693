import pytest

from swarm_sim.ros.pacing import MAX_LAG, Rate, SpeedMeter, Throttle


def test_ticks_keep_their_average_period_and_delays_are_not_caught_up():
    assert Throttle(None).wait_after_tick(0.0) == 0.0
    throttle = Throttle(2.0)
    throttle.start(10.0)
    assert throttle.wait_after_tick(10.02) == pytest.approx(0.03)
    assert throttle.wait_after_tick(10.09) == pytest.approx(0.01)
    assert throttle.wait_after_tick(10.20) == 0.0
    assert throttle.wait_after_tick(10.20) == pytest.approx(0.0)  # catches up
    throttle = Throttle(1.0)
    throttle.start(0.0)
    throttle.wait_after_tick(100.0)
    waits = [throttle.wait_after_tick(100.0) for _ in range(20)]
    assert sum(wait == 0.0 for wait in waits) == pytest.approx(MAX_LAG / 0.1, abs=1)


def test_rate_and_speed():
    rate = Rate(0.5)
    assert rate.is_due(0.0)
    assert not rate.is_due(0.4)
    assert rate.is_due(0.5)
    meter = SpeedMeter()
    meter.start(10.0, 5.0)
    meter.update(12.0, 11.0)
    assert meter.factor == 3.0

"""The radio: range, loss and delay, independent of the order of arrival."""

import numpy as np
import pytest

from swarm_common.model.beacon import empty_beacons
from swarm_common.model.errors import ConfigError
from swarm_sim.sensing.radio import Radio, RadioConfig
from tests.oracles import radio as oracle


def beacons(count):
    result = empty_beacons(count)
    result["id"] = np.arange(1, count + 1)
    result["held"][:, 3, 1] = np.arange(count) + 0.5
    return result


@pytest.mark.parametrize("loss", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("seed", [0, 7])
def test_who_hears_whom_equals_the_slow_twin(seed, loss):
    rng = np.random.default_rng(seed)
    radio = Radio(RadioConfig(range=3.0, loss=loss), 12, seed)
    sent = beacons(12)
    for tick in range(20):
        positions = rng.uniform(0.0, 8.0, (12, 2))
        silent = set(rng.integers(0, 12, 2).tolist())
        radio.send(tick, [None if i in silent else sent[i] for i in range(12)], positions)
        senders = [i for i in range(12) if i not in silent]
        for receiver in range(12):
            expected = oracle.heard(positions.tolist(), senders, receiver, tick, seed, 3.0, loss)
            received = radio.heard(receiver)
            assert (received["id"] - 1).tolist() == expected
            assert np.array_equal(received, sent[expected])


@pytest.mark.parametrize(("delay", "ticks"), [(0.0, 1), (0.1, 2), (0.25, 4)])
def test_a_beacon_takes_one_tick_and_the_delay(delay, ticks):
    radio = Radio(RadioConfig(delay=delay), 2, 0)
    positions = np.zeros((2, 2))
    sent = beacons(2)
    heard = []
    for tick in range(6):
        heard.append(len(radio.heard(1)))
        radio.send(tick, [sent[0] if tick == 0 else None, None], positions)
    assert heard == [int(tick == ticks) for tick in range(6)]


def test_the_share_of_lost_messages_is_the_one_asked_for():
    radio = Radio(RadioConfig(loss=0.2), 20, 5)
    sent = list(beacons(20))
    positions = np.zeros((20, 2))
    heard = 0
    for tick in range(100):
        radio.send(tick, sent, positions)
        heard += sum(len(radio.heard(i)) for i in range(20))
    assert heard / (100 * 20 * 19) == pytest.approx(0.8, abs=0.01)


@pytest.mark.parametrize(
    "values",
    [{"range": 0.0}, {"loss": 1.5}, {"loss": -0.1}, {"delay": -1.0}, {"range": float("nan")}],
)
def test_impossible_values_are_refused(values):
    with pytest.raises(ConfigError, match=r"radio\."):
        RadioConfig(**values)

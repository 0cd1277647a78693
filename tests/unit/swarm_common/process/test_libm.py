"""Arrays get the bits that `math` gives their numbers."""

import math

import numpy as np

from swarm_common.process.libm import arctan2, exp, log

X = np.random.default_rng(0).uniform(-30.0, 3.0, (40, 50))
Y = np.random.default_rng(1).uniform(-3.0, 3.0, (40, 50))


def test_arrays_get_the_bits_of_math():
    assert exp(X).tolist() == [[math.exp(x) for x in row] for row in X.tolist()]
    assert log(-X[X < 0.0]).tolist() == [math.log(-x) for x in X.ravel().tolist() if x < 0.0]
    assert log(np.float64(0.5)) == math.log(0.5)
    angles = [math.atan2(y, x) for y, x in zip(Y.ravel().tolist(), X.ravel().tolist(), strict=True)]
    assert arctan2(Y.ravel(), X.ravel()).tolist() == angles

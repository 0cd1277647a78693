"""exp, log and arctan2 of arrays, with the same last bits on every processor.

NumPy computes these in a way of its own where a processor has AVX-512, and the last bits differ.
Here each number goes through the C library, as with `math`. For what moves robots.
"""

from __future__ import annotations

import numpy as np

from swarm_common.model.records import FloatArray
from swarm_common.process.numba_compat import njit


def exp(values: FloatArray) -> FloatArray:
    """Return e to the power of each value; any shape."""
    flat: FloatArray = _exp(np.ravel(values))
    return flat.reshape(np.shape(values))


def log(values: FloatArray) -> FloatArray:
    """Return the natural logarithm of each value; any shape."""
    flat: FloatArray = _log(np.ravel(values))
    return flat.reshape(np.shape(values))


@njit(cache=True)
def arctan2(y: FloatArray, x: FloatArray) -> FloatArray:
    """Return angles (n,) [rad] of points, seen from the origin.

    Args:
        y: (n,).
        x: (n,).
    """
    return np.arctan2(y, x)


@njit(cache=True)
def _exp(values: FloatArray) -> FloatArray:
    return np.exp(values)


@njit(cache=True)
def _log(values: FloatArray) -> FloatArray:
    return np.log(values)

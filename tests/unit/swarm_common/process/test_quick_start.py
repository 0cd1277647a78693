"""What a start spares is spared, and nothing else changes."""

from __future__ import annotations

import gc
import subprocess
import sys

import pytest

from swarm_common.process.quick_start import without_collector

KERNEL = """
import sys
from swarm_common.process.quick_start import load_numba
load_numba()
from swarm_nav.planning import distance_kernels
import numpy as np
occupied = np.zeros((9, 9), np.bool_)
occupied[4, 4] = True
assert distance_kernels.distance_cells(occupied)[4, 0] == 4.0
assert "scipy.linalg" not in sys.modules
import scipy.linalg.cython_blas
"""


def test_kernels_run_without_scipy_and_scipy_can_be_imported_after() -> None:
    subprocess.run([sys.executable, "-c", KERNEL], check=True, timeout=300)


def test_the_collector_is_off_within_and_on_again_after_a_failure() -> None:
    def fail() -> None:
        with without_collector():
            assert not gc.isenabled()
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert gc.isenabled()
    gc.unfreeze()

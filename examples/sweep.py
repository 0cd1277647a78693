"""Makespans by safety margin and seed, on all processors.

python examples/sweep.py [SEEDS]
"""

import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from swarm_workbench import run_scenario

MARGINS = (0.03, 0.05, 0.08)  # [m]
SEEDS = int(sys.argv[1]) if len(sys.argv) > 1 else 5


def makespan(case: tuple[float, int]) -> float:
    """Return the makespan [s] of one run; NaN if a goal was missed."""
    margin, seed = case
    parameters = {"traffic.safety_margin": margin}
    result = run_scenario("corridor", robots=4, seed=seed, parameters=parameters)
    return result.makespan or np.nan


if __name__ == "__main__":
    cases = [(margin, seed) for margin in MARGINS for seed in range(SEEDS)]
    with ProcessPoolExecutor() as pool:
        table = np.reshape(list(pool.map(makespan, cases)), (len(MARGINS), SEEDS))
    for margin, row in zip(MARGINS, table, strict=True):
        print(f"margin {margin:.2f} m: median {np.nanmedian(row):.1f} s, {row.round(1)}")

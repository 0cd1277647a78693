"""Short runs give the trajectories that are kept, to the last bit, on every processor.

`python -m tests.kept_trajectories` writes the hashes anew.
"""

import functools
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from swarm_common.process.compiled_code import SWITCH, compiled_folder, is_compiled
from tests.fakes.programs import run_program
from tests.kept_trajectories import KEPT, RUNS, libraries
from tests.kept_trajectories import trajectory as run_of

ROOT = Path(__file__).resolve().parents[2]
OTHERS = ("corridor, realistic", "walkers, realistic, rigid bodies")
# NumPy and OpenBLAS without the vector code that they chose for this processor.
SIMD = np.show_config(mode="dicts")["SIMD Extensions"]
PLAIN_NUMPY = {"NPY_DISABLE_CPU_FEATURES": ",".join(SIMD.get("found", ()))}
OLD_PROCESSOR = PLAIN_NUMPY | {"OPENBLAS_CORETYPE": "Prescott"}

trajectory = functools.cache(run_of)  # of this process


def in_another_process(variables, *names):
    ended = run_program(
        (sys.executable, "-m", "tests.kept_trajectories", *names), variables, cwd=ROOT, check=True
    )
    return json.loads(ended.stdout.splitlines()[-1])


@pytest.mark.parametrize("name", RUNS)
def test_a_run_gives_the_trajectories_that_are_kept(name):
    kept = json.loads(KEPT.read_text(encoding="utf-8"))
    if kept["libraries"] != libraries():
        pytest.skip(f"hashes are kept for {kept['libraries']}")
    assert trajectory(name) == kept["runs"][name]


def test_compiled_navigators_and_their_sources_drive_alike():
    assert compiled_folder().is_dir(), "not compiled from these sources: call swarm-setup"
    names = [name for name in RUNS if name not in OTHERS]
    other = {SWITCH: "1" if is_compiled() else "0"}
    assert in_another_process(other, *names) == {name: trajectory(name) for name in names}


def test_other_vector_code_changes_no_trajectory():
    here = {name: trajectory(name) for name in OTHERS}
    assert in_another_process(OLD_PROCESSOR, *OTHERS) == here


@pytest.mark.long
def test_kernels_compiled_for_any_processor_change_no_trajectory(tmp_path):
    target = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    cold = {"NUMBA_CACHE_DIR": str(tmp_path)}
    assert in_another_process(target | cold, OTHERS[0]) == {OTHERS[0]: trajectory(OTHERS[0])}

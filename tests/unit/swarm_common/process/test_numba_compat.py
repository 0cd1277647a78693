"""Compiled kernels on disk: what an update or a full disk leaves there ends no process."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[4]
KERNEL = """
from typing import NamedTuple
from swarm_common.process.numba_compat import njit

class {name}(NamedTuple):
    x: float

@njit(cache=True)
def double(place):
    return 2.0 * place.x

print(double({name}(2.0)), sum(double.stats.cache_hits.values()))
"""


@pytest.fixture
def run(tmp_path: Path):
    """Return what runs a module in `tmp_path` with a class of some name."""

    def run_module(name: str) -> str:
        (tmp_path / "kernel.py").write_text(KERNEL.format(name=name), encoding="utf-8")
        done = subprocess.run(
            (
                sys.executable,
                "-c",
                "import kernel",
            ),
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": f"{tmp_path}:{ROOT}"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    return run_module


def test_a_kernel_is_loaded_and_a_renamed_class_has_it_compiled_again(run) -> None:
    assert run("Place") == "4.0 0"
    assert run("Place") == "4.0 1"
    assert run("Spot") == "4.0 0"
    assert run("Spot") == "4.0 1"


def test_a_place_that_cannot_be_used_has_it_compiled(run, tmp_path: Path) -> None:
    """Files of another user, or a full disk, ended the process."""
    run("Place")
    for path in (tmp_path / "__pycache__").glob("*.nbi"):
        path.unlink()
        path.mkdir()
    assert run("Place") == "4.0 0"


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_file_that_was_cut_short_is_written_anew(run, tmp_path: Path, suffix: str) -> None:
    run("Place")
    for path in (tmp_path / "__pycache__").glob(f"*.{suffix}"):
        path.write_bytes(path.read_bytes()[:-20])
    assert run("Place") == "4.0 0"
    assert run("Place") == "4.0 1"

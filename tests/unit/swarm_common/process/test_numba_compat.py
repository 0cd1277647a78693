"""Compiled kernels on disk: what an update or a full disk leaves there ends no process."""

import os
import sys
from pathlib import Path

import pytest

from swarm_common.process import numba_compat
from tests.fakes.programs import run_program

ROOT = Path(__file__).parents[4]
KERNEL = """
from typing import NamedTuple
from swarm_common.process.numba_compat import njit
FACTOR = 2.0

class {name}(NamedTuple):
    x: float

@njit(cache=True)
def double(place):
    return FACTOR * place.x

print(double({name}(2.0)), sum(double.stats.cache_hits.values()))
"""


@pytest.fixture
def run(tmp_path):
    """Return what runs a module in `tmp_path` with a class of some name."""

    def run_module(name):
        (tmp_path / "kernel.py").write_text(KERNEL.format(name=name), encoding="utf-8")
        done = run_program(
            (sys.executable, "-c", "import kernel"),
            {"PYTHONPATH": f"{tmp_path}:{ROOT}", "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
            cwd=tmp_path,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    return run_module


def test_a_kernel_is_loaded_and_a_renamed_class_has_it_compiled_again(run):
    assert run("Place") == "4.0 0"
    assert run("Place") == "4.0 1"
    assert run("Spot") == "4.0 0"
    assert run("Spot") == "4.0 1"


def test_a_place_that_cannot_be_used_has_it_compiled(run, tmp_path):
    """Files of another user, or a full disk, ended the process."""
    run("Place")
    for path in (tmp_path / "cache").rglob("*.nbi"):
        path.unlink()
        path.mkdir()
    assert run("Place") == "4.0 0"


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_file_that_was_cut_short_is_written_anew(run, tmp_path, suffix):
    run("Place")
    for path in (tmp_path / "cache").rglob(f"*.{suffix}"):
        path.write_bytes(path.read_bytes()[:-20])
    assert run("Place") == "4.0 0"
    assert run("Place") == "4.0 1"


def test_another_checkout_finds_its_kernels_and_what_they_call_counts(tmp_path):
    """numba itself keeps a callee's old code in callers whose own file did not change."""
    caller = "from swarm_common.process.numba_compat import njit\nfrom swarm_a.callee import one\n"
    caller += "@njit(cache=True)\ndef two():\n    return 2 * one()\n"
    callee = "from swarm_common.process.numba_compat import njit\n"
    callee += "@njit(cache=True)\ndef one():\n    return {}\n"

    modules = ("process/numba_compat", "process/home", "process/private_parts", "model/errors")
    packages = ("__init__", "process/__init__", "model/__init__")

    def say(checkout, value):
        folder = tmp_path / checkout
        texts = {"swarm_a/__init__": "", "swarm_a/caller": caller}
        texts |= {"swarm_a/callee": callee.format(value)}
        texts |= {f"swarm_common/{name}": "" for name in packages}
        for name in (f"swarm_common/{name}" for name in modules):
            texts[name] = (ROOT / f"{name}.py").read_text(encoding="utf-8")
        for name, text in texts.items():
            file = folder / f"{name}.py"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        program = "from swarm_a.caller import two; print(two(), sum(two.stats.cache_hits.values()))"
        return run_program(
            (sys.executable, "-c", program),
            {"PYTHONPATH": "", "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
            cwd=folder,
            check=True,
        ).stdout.strip()

    assert say("one", 3) == "6 0"
    assert say("other", 3) == "6 1"
    assert say("one", 4) == "8 0"


def test_the_oldest_kernels_go_and_what_others_keep_there_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(numba_compat, "kernel_folder", lambda: tmp_path)
    monkeypatch.setattr(numba_compat, "MOST_KEPT", 2)
    (tmp_path / "of_another_library").mkdir()
    for age, name in enumerate(("b" * 16, "a" * 16, "c" * 16)):
        (tmp_path / name).mkdir()
        os.utime(tmp_path / name, (1000.0 + age, 1000.0 + age))
    place = numba_compat._ContentLocator(lambda: None, __file__)
    place.ensure_cache_path()
    new = Path(place.get_cache_path()).name
    kept = {path.name for path in tmp_path.iterdir()}
    assert kept == {"of_another_library", "c" * 16, new}

"""The compiled navigators: what is compiled, where they are found, and when they are not used."""

import ast
import os
import subprocess
import sys

import pytest

from swarm_common.process import compiled_code
from swarm_nav.reservation import tube
from swarm_nav.traffic import gate
from swarm_setup import compiled

TRIAL = "import swarm_nav.traffic.arbiter as made; print(made.__file__)"
ADD = "def add(a: int, b: int) -> int:\n    return a + b\n"


def test_what_runs_in_every_tick_is_compiled_and_the_rest_is_there():
    names = {path.name for path in compiled.modules()}
    assert {"navigator.py", "arbiter.py", "tube.py", "neighbor_table.py"} <= names
    assert not [name for name in names if name.endswith("_kernels.py")]
    assert all((compiled_code.ROOT / "swarm_nav" / name).is_file() for name in compiled.LEFT)


def test_nothing_compiled_compares_tuples_by_identity():
    """Mypyc keeps tuples without their object, so that each look at one makes another."""
    found = []
    for path in compiled.modules():
        tree = ast.parse(path.read_text())
        tuples = {
            node.target.attr
            for node in ast.walk(tree)
            if isinstance(node, ast.AnnAssign)
            and isinstance(node.target, ast.Attribute)
            and "tuple[" in ast.unparse(node.annotation)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Is | ast.IsNot):
                sides = (node.left, node.comparators[0])
                is_with_none = any(isinstance(side, ast.Constant) for side in sides)
                names = {side.attr for side in sides if isinstance(side, ast.Attribute)}
                if not is_with_none and names & tuples:
                    found.append(f"{path.name}:{node.lineno}: {ast.unparse(node)}")
    assert not found


def test_a_changed_source_or_the_oldest_states_go(tmp_path, monkeypatch, small):
    monkeypatch.setattr(compiled_code, "ROOT", tmp_path)
    source = tmp_path / "swarm_nav" / "a.py"
    source.parent.mkdir()
    source.write_text("x = 1\n")
    before = compiled_code.compiled_folder()
    assert compiled_code.compiled_folder() == before
    source.write_text("x = 2\n")
    assert compiled_code.compiled_folder() != before
    for number in range(compiled.MOST_KEPT + 1):
        (small / f"{number}").mkdir(parents=True)
        os.utime(small / f"{number}", (number, number))
    assert compiled.ensure_compiled()
    kept = {path.name for path in small.iterdir()}
    assert len(kept) == compiled.MOST_KEPT
    assert "0" not in kept
    assert compiled_code.compiled_folder().name in kept


def test_the_switch_has_python_run_the_sources():
    environment = os.environ | {compiled_code.SWITCH: "1"}
    done = subprocess.run(
        (sys.executable, "-c", TRIAL), env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip().endswith("arbiter.py")


@pytest.mark.skipif(not compiled_code.is_compiled(), reason="the sources have changed")
def test_a_test_cannot_replace_what_is_compiled(monkeypatch):
    """Compiled callers would go on to call the old one, and the test would pass whatever it is."""
    for target in ((tube.Tube, "cut"), (gate, "narrow_region"), ("swarm_nav.traffic.gate.Gate",)):
        with pytest.raises(pytest.fail.Exception, match=r"swarm_nav\..* is compiled"):
            monkeypatch.setattr(*target, None)
    monkeypatch.setattr(gate, "MOST_AREA", gate.MOST_AREA)  # a number is looked up each time


@pytest.fixture
def small(tmp_path, monkeypatch):
    """Put one small module in the place of all; return where compiled code is kept."""
    root, kept = tmp_path / "sources", tmp_path / "kept"
    for name in ("swarm_nav/__init__.py", "swarm_nav/traffic/__init__.py"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).touch()
    (root / "swarm_nav/traffic/sums.py").write_text(ADD)
    for package in compiled_code.PACKAGES:
        (root / package).mkdir(exist_ok=True)
    (root / "mypy_extensions.py").touch()  # as among installed packages, where mypy refuses it
    for module in (compiled_code, compiled):
        monkeypatch.setattr(module, "ROOT", root)
        monkeypatch.setattr(module, "compiled_folders", lambda: kept)
    return kept


def test_what_was_compiled_is_found_and_gives_the_same(small):
    assert compiled.ensure_compiled()
    assert not compiled.ensure_compiled()
    finder = compiled_code._Finder(compiled_code.compiled_folder())
    spec = finder.find_spec("swarm_nav.traffic.sums", None)
    assert spec.origin.endswith(compiled_code.SUFFIX)
    assert finder.find_spec("swarm_nav.traffic.others", None) is None
    trial = (
        "import sys; from pathlib import Path; from swarm_common.process import compiled_code as c;"
        "sys.meta_path.insert(0, c._Finder(Path(sys.argv[1]))); import swarm_nav;"
        f"swarm_nav.__path__.insert(0, {str(compiled.ROOT / 'swarm_nav')!r});"
        "sys.modules.pop('swarm_nav.traffic', None);"
        "from swarm_nav.traffic.sums import add; print(add(2, 3), type(add).__name__)"
    )
    folder = str(compiled_code.compiled_folder())
    done = subprocess.run(
        (sys.executable, "-c", trial, folder), capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["5", "builtin_function_or_method"]


def test_what_mypyc_refuses_leaves_nothing(small):
    (compiled.ROOT / "swarm_nav/traffic/sums.py").write_text("x: int = 'a'\n")
    with pytest.raises(compiled.BuildError, match="Incompatible types"):
        compiled.ensure_compiled()
    assert not list(small.iterdir())

"""Each folder's docstring lists its modules: all of them, and no others."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^    (\w+)  +\S", re.MULTILINE)
MAPS = {
    path.parent: rows
    for path in sorted(ROOT.glob("swarm_*/**/__init__.py"))
    if (rows := set(ROW.findall(ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "")))
}


@pytest.mark.parametrize("folder", MAPS, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_a_folders_map_names_its_modules(folder: Path) -> None:
    modules = {path.stem for path in folder.glob("*.py")} - {"__init__", "__main__"}
    folders = {path.parent.name for path in folder.glob("*/__init__.py")}
    assert modules <= MAPS[folder], "not on the map"
    assert MAPS[folder] <= modules | folders, "not there"


def test_the_folders_of_the_large_packages_have_maps() -> None:
    assert {"swarm_nav", "swarm_sim", "swarm_view", "swarm_bench"} <= {
        folder.relative_to(ROOT).parts[0] for folder in MAPS
    }

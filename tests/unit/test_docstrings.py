"""Docstrings: a folder's lists its modules, a public function's describes its parameters."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^    (\w+)  +\S", re.MULTILINE)
MAPS = {
    path.parent: rows
    for path in sorted(ROOT.glob("swarm_*/**/__init__.py"))
    if (rows := set(ROW.findall(ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "")))
}
# Packages and modules whose public functions describe all of their parameters.
DESCRIBED = (
    "swarm_bench",
    "swarm_commander/mission",
    "swarm_commander/run",
    "swarm_common",
    "swarm_nav",
    "swarm_sim",
)
ARGS = re.compile(r"^Args:\n((?: {4}.*\n?|\n)+)", re.MULTILINE)
ENTRY = re.compile(r"^ {4}\*{0,2}(\w+): \S", re.MULTILINE)
Function = ast.FunctionDef | ast.AsyncFunctionDef


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


@pytest.mark.parametrize("place", DESCRIBED)
def test_public_functions_describe_their_parameters(place: str) -> None:
    files = sorted((ROOT / place).rglob("*.py")) or [ROOT / place]
    wrong = [
        f"{path.relative_to(ROOT)}:{function.lineno} {function.name}: {', '.join(missing)}"
        for path in files
        for function, is_method in public_functions(ast.parse(path.read_text("utf-8")), False)
        if (missing := sorted(parameters(function, is_method) ^ described(function)))
    ]
    assert not wrong, "without a line under Args:, or no parameter:\n" + "\n".join(wrong)


def public_functions(node: ast.AST, is_class: bool) -> Iterator[tuple[Function, bool]]:
    """Yield the public functions below a node, nested ones too, and whether each is a method."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ClassDef):
            if not child.name.startswith("_"):
                yield from public_functions(child, True)
        elif isinstance(child, Function):
            is_public = not child.name.startswith("_") or child.name == "__init__"
            if is_public and not is_command(child):
                yield child, is_class
            yield from public_functions(child, False)
        else:
            yield from public_functions(child, is_class)


def is_command(function: Function) -> bool:
    """Whether it is a command: its docstring is its --help, and its options have own texts."""
    calls = (item.func for item in function.decorator_list if isinstance(item, ast.Call))
    return any(isinstance(call, ast.Attribute) and call.attr == "command" for call in calls)


def parameters(function: Function, is_method: bool) -> set[str]:
    """Return the names of a function's parameters without self and cls, and without `_`."""
    given = function.args
    names = [item.arg for item in (*given.posonlyargs, *given.args)]
    decorators = {item.id for item in function.decorator_list if isinstance(item, ast.Name)}
    if is_method and "staticmethod" not in decorators:
        del names[0]
    names += [item.arg for item in (given.vararg, *given.kwonlyargs, given.kwarg) if item]
    return {name for name in names if not name.startswith("_")}


def described(function: Function) -> set[str]:
    """Return the names under `Args:` in the docstring of a function."""
    section = ARGS.search(ast.get_docstring(function) or "")
    return set(ENTRY.findall(section[1])) if section else set()

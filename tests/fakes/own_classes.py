"""Every class in the sources, and the class that each name of a base stands for."""

import ast
import functools
import tomllib
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PACKAGES: list[str] = PROJECT["tool"]["importlinter"]["root_packages"]


class OwnClass(NamedTuple):
    """One class of the sources."""

    module: str
    name: str
    bases: tuple[str, ...]  # each with its module, like `swarm_nav.behaviour.navigator.Navigator`


def classes_in(folder: str) -> list[OwnClass]:
    """Return the classes of all files under a folder of the checkout, also those in functions."""
    found = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        module = module_of(path)
        found += [
            OwnClass(module, node.name, tuple(full_name(module, ast.unparse(b)) for b in bases))
            for node in ast.walk(tree_of(module))
            if isinstance(node, ast.ClassDef)
            and (bases := [b.value if isinstance(b, ast.Subscript) else b for b in node.bases])
        ]
    return found


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@functools.cache
def tree_of(module: str) -> ast.Module:
    """Return the syntax tree of a module; an empty one where there is no such file of ours."""
    path = ROOT / module.replace(".", "/")
    files = (path.with_suffix(".py"), path / "__init__.py")
    return ast.parse(next((f.read_text("utf-8") for f in files if f.is_file()), ""))


@functools.cache
def _imports(module: str) -> dict[str, str]:
    """Return what each name that a module imports stands for."""
    names = {}
    for node in ast.walk(tree_of(module)):
        if isinstance(node, ast.Import):
            names |= {one.asname: one.name for one in node.names if one.asname}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names |= {one.asname or one.name: f"{node.module}.{one.name}" for one in node.names}
    return names


def full_name(module: str, name: str) -> str:
    """Return the module that defines what a name in a module stands for, and its name there."""
    first, _, rest = name.partition(".")
    target = _imports(module).get(first)
    if target is None:
        is_imported_whole = any(tree_of(name.rpartition(".")[0]).body)
        return name if is_imported_whole else f"{module}.{name}"
    target = f"{target}.{rest}" if rest else target
    owner, _, last = target.rpartition(".")
    return full_name(owner, last) if tree_of(owner).body else target

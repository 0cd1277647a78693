"""A version of a library in which a private part moved is told in plain words."""

import ast
from pathlib import Path

import pytest

from swarm_common.middleware import rclpy_compat
from swarm_common.process import numba_compat
from swarm_common.process.private_parts import MovedPartError, require
from swarm_describe.files import xacro_compat
from swarm_view.scene import viser_compat

ROOT = Path(__file__).parents[4]
COMPATS = (
    ("numba", numba_compat),
    ("ros-jazzy-rclpy", rclpy_compat),
    ("viser", viser_compat),
    ("xacro", xacro_compat),
)


@pytest.mark.parametrize(("library", "compat"), COMPATS, ids=[name for name, _ in COMPATS])
def test_every_part_is_there_and_one_that_moved_is_named(library, compat):
    require(library, compat.__name__, compat.PARTS)
    owner, _ = compat.PARTS[0]
    with pytest.raises(MovedPartError) as caught:
        require(library, compat.__name__, [*compat.PARTS, (owner, "_moved_elsewhere")])
    for word in (f"{library} ", f"has no {owner.__name__}._moved_elsewhere", compat.__name__):
        assert word in str(caught.value)


def foreign_private_parts():
    """Yield where a module uses an attribute with an underscore that no module of ours sets."""
    files = [*ROOT.glob("swarm_*/**/*.py"), *ROOT.glob("benchmarks/**/*.py")]
    trees = {path: ast.parse(path.read_text("utf-8")) for path in files}
    nodes = [node for tree in trees.values() for node in ast.walk(tree)]
    own = {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    own |= {node.id for node in nodes if isinstance(node, ast.Name)}
    own |= {
        node.attr
        for node in nodes
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    }
    for path, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and node.attr.startswith("_"):
                is_ours = node.attr in own or node.attr.startswith("__")
                is_public = node.attr in ("_exit", "_fields")  # documented in spite of their names
                if not (is_ours or is_public or path.stem.endswith("_compat")):
                    yield f"{path.relative_to(ROOT)}:{node.lineno} {ast.unparse(node)}"


def test_private_parts_are_in_compat_modules_and_moved_ones_are_named():
    assert list(foreign_private_parts()) == []

    class Library:
        def __init__(self):
            self._kept = 1

    require("viser", "ours", [(Library.__init__, "_kept")])
    with pytest.raises(MovedPartError, match=r"Library.__init__\._gone"):
        require("viser", "ours", [(Library.__init__, "_gone")])

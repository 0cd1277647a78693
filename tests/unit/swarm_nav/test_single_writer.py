"""Only the arbiter writes what a robot holds, and its path; by the syntax tree of all packages."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
TUBE = ROOT / "swarm_nav" / "reservation" / "tube.py"  # it may be compiled
WRITERS = {
    "swarm_nav/traffic/arbiter.py",
    "swarm_nav/traffic/robot_state.py",  # sets up the tube that it creates
    "swarm_nav/launch/warm_up.py",  # likewise
}
CLASS = next(
    node
    for node in ast.walk(ast.parse(TUBE.read_text(encoding="utf-8")))
    if isinstance(node, ast.ClassDef) and node.name == "Tube"
)


def targets_of(node):
    """Yield what a statement assigns to, inside tuples and subscripts, too."""
    found = getattr(node, "targets", [getattr(node, "target", None)])[:]
    while found:
        target = found.pop()
        if isinstance(target, ast.Tuple | ast.List):
            found += target.elts
        elif isinstance(target, ast.Subscript | ast.Starred):
            found.append(target.value)
        elif isinstance(target, ast.expr):
            yield target


def changing_methods():
    """Return the methods of the tube that change it, themselves or by others."""
    methods = {node.name: node for node in CLASS.body if isinstance(node, ast.FunctionDef)}
    changing: set[str] = set()
    while True:
        found = {
            name
            for name, method in methods.items()
            for node in ast.walk(method)
            if any(ast.unparse(target).startswith("self.") for target in targets_of(node))
            or (
                isinstance(node, ast.Call)
                and ast.unparse(node.func).removeprefix("self.") in changing
            )
        }
        if found == changing:
            return {name for name in changing if not name.startswith("_")}
        changing = found


CHANGING = changing_methods()


def changes_in(source):
    """Return the expressions of a source that change a tube, by whatever name it has there."""
    nodes = list(ast.walk(ast.parse(source)))
    names = {"tube"}
    for node in nodes:
        if isinstance(node, ast.Assign):
            values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            for target, value in zip(list(targets_of(node))[::-1], values, strict=False):
                if ast.unparse(value).endswith(".tube"):
                    names.add(ast.unparse(target))

    def is_tube(owner):
        text = ast.unparse(owner)
        return text in names or text.endswith(".tube")

    found = []
    for node in nodes:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            if node.func.attr in CHANGING and is_tube(node.func.value):
                found.append(ast.unparse(node.func))
        found += [
            ast.unparse(target)
            for target in targets_of(node)
            if isinstance(target, ast.Attribute) and is_tube(target.value)
        ]
    return found


def test_only_the_arbiter_writes_held_space_and_path():
    files = [path for path in ROOT.glob("swarm_*/**/*.py") if path.parent.name != "reservation"]
    assert len(files) > 100
    writers = {
        name: found
        for path in files
        if (name := path.relative_to(ROOT).as_posix()) not in WRITERS
        and (found := changes_in(path.read_text(encoding="utf-8")))
    }
    assert writers == {}


def test_the_writers_are_needed():
    assert all(changes_in((ROOT / name).read_text(encoding="utf-8")) for name in WRITERS)
    assert {"adopt", "cut", "reset", "publish", "track", "forget_requests"} <= CHANGING
    assert not {"gap", "nearest", "length_ahead", "next_corner"} & CHANGING


@pytest.mark.parametrize(
    ("planted", "found"),
    [
        ("robot.tube.cut()", "robot.tube.cut"),
        ("s, held = self._s, self._s.tube\nheld.adopt(path)", "held.adopt"),
        ("def f(tube):\n    tube.stop += 1", "tube.stop"),
        ("space = robot.tube\nspace.points[0] = 1.0", "space.points"),
        ("(robot.tube.tail, x) = 1, 2", "robot.tube.tail"),
    ],
)
def test_a_planted_writer_is_found(planted, found):
    assert changes_in(planted) == [found]

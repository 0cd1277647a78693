"""Only the arbiter and the held space itself change what a robot holds and its path."""

from __future__ import annotations

import ast
from pathlib import Path

import swarm_nav

ROOT = Path(swarm_nav.__file__).parent
WRITERS = {"traffic/arbiter.py", "traffic/robot_state.py"}  # and all of reservation/
CHANGES = {
    "adopt", "cut", "shrink_to_place", "release_beyond", "release_ahead", "track", "advance",
    "withdraw", "forget_requests",
}  # fmt: skip
# between two ticks: a map, a pose or parameters from outside, and what goes into the beacon
OUTSIDE = {"hold_place", "publish", "record_rest", "announce_margin", "announce_priorities"}


def changes_in(path: Path) -> list[str]:
    """Return the statements of a file that change a held space or a path."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            owner = ast.unparse(node.func.value)
            is_space = owner.rpartition(".")[2] in ("tube", "robot", "s", "_s")
            if is_space and node.func.attr in CHANGES | OUTSIDE:
                found.append(ast.unparse(node.func))
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [
            each
            for target in targets
            for each in (target.elts if isinstance(target, ast.Tuple) else [target])
        ]
        if isinstance(node, ast.AugAssign):
            targets = [node.target]
        found += [
            ast.unparse(target)
            for target in targets
            if isinstance(target, ast.Attribute) and ast.unparse(target.value).endswith("tube")
        ]
    return found


def test_rules_and_controllers_change_nothing() -> None:
    writers = {}
    for path in sorted(ROOT.rglob("*.py")):
        name = path.relative_to(ROOT).as_posix()
        if name in WRITERS or name.startswith(("reservation/", "launch/warm_up")):
            continue
        found = changes_in(path)
        if name == "behaviour/navigator.py":
            found = [call for call in found if call.rpartition(".")[2] not in OUTSIDE]
        if found:
            writers[name] = found
    assert writers == {}


def test_the_check_sees_a_writer() -> None:
    assert changes_in(ROOT / "traffic" / "arbiter.py")

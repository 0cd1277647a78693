"""No two classes of different meaning share a name: a name is one class.

What users import has the plain names, which the parts inside have, too.
"""

import ast
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROTOCOLS = ROOT / "swarm_nav" / "interfaces.py"  # named as the parts that they stand for
FOR_USERS = {"Goal", "Report", "Robot", "Swarm", "World"}  # of swarm_workbench


def test_every_class_has_a_name_of_its_own():
    places: defaultdict[str, list[str]] = defaultdict(list)
    for pattern in ("swarm_*/**/*.py", "benchmarks/**/*.py", "tools/*.py"):
        for path in set(ROOT.glob(pattern)) - {PROTOCOLS}:
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    if node.name in FOR_USERS and path.parent.name == "swarm_workbench":
                        continue
                    places[node.name].append(str(path.relative_to(ROOT)))
    assert {name: found for name, found in places.items() if len(found) > 1} == {}

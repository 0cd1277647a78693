"""Files of results, as a bench leaves them."""

import json
from collections.abc import Iterable
from pathlib import Path

from swarm_bench.execution.store import Kept


def add_lines(path: Path, results: Iterable[Kept]) -> None:
    """Add results to a file of JSON lines."""
    path.parent.mkdir(exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        file.writelines(f"{json.dumps(result.as_json())}\n" for result in results)

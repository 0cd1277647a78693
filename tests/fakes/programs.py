"""Programs that tests run to their end, from this checkout, with their output."""

import os
import subprocess
from collections.abc import Iterable, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run_program(
    command: Iterable[str],
    variables: Mapping[str, str] | None = None,
    *,
    cwd: Path | None = None,
    check: bool = False,
    timeout: float = 600.0,
) -> subprocess.CompletedProcess[str]:
    """Return how a program ended; it finds our packages, whatever its folder is."""
    return subprocess.run(
        tuple(command),
        env=os.environ | {"PYTHONPATH": str(ROOT)} | dict(variables or {}),
        cwd=cwd,
        check=check,
        timeout=timeout,
        capture_output=True,
        text=True,
    )

"""Edition of the software: hosts of one swarm must run the same."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

DISTRIBUTION = "swarm-workbench"
# Packages whose code decides what a robot does, and what the hosts say to each other.
DECIDING = ("swarm_common", "swarm_describe", "swarm_nav", "swarm_commander")
DIGITS = 10  # of the digest that are shown


def edition(packages: Sequence[str] = DECIDING) -> str:
    """Return the version and a digest of the code that hosts must have in common."""
    root = Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for package in packages:
        for path in sorted((root / package).rglob("*.py")):
            digest.update(str(path.relative_to(root)).encode())
            digest.update(path.read_bytes())
    return f"{_version()} ({digest.hexdigest()[:DIGITS]})"


def _version() -> str:
    try:
        return metadata.version(DISTRIBUTION)
    except metadata.PackageNotFoundError:
        return "not installed"

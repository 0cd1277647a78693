"""Run folders below the current folder."""

from __future__ import annotations

from pathlib import Path

RUNS = Path("runs")
LATEST = "latest"


def run_folders() -> list[str]:
    """Return the folders of runs, the latest first; shells offer them."""
    folders = sorted((path.parent for path in RUNS.glob("*/config")), key=str, reverse=True)
    return [str(folder) for folder in folders]

"""plotly.js as the installed package brings it, packed for pages that need nothing else."""

from __future__ import annotations

import base64
import functools
import gzip
import importlib.util
from pathlib import Path

FILE = Path("package_data") / "plotly.min.js"


@functools.cache
def plotly_js() -> str:
    """Return plotly.js, gzipped and in base64; empty if the package `plotly` is not installed."""
    found = importlib.util.find_spec("plotly")
    for folder in (found.submodule_search_locations or []) if found is not None else []:
        path = Path(folder) / FILE
        if path.is_file():
            return base64.b64encode(gzip.compress(path.read_bytes(), 9, mtime=0)).decode()
    return ""

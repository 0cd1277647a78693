"""The physics engine of a world that names none: PyBullet is not there for all Pythons."""

from __future__ import annotations

import functools
import importlib.util

BULLET, PLANAR = "bullet", "planar"
NO_WHEELS = (
    "PyBullet is not installed (PyPI has it ready for Python 3.11 only): robots drive planar, as"
    " with --drive planar"
)


@functools.cache
def usual_engine() -> str:
    """Return ``bullet`` where PyBullet is installed, else ``planar``."""
    return BULLET if importlib.util.find_spec("pybullet") is not None else PLANAR

"""The default physics engine: PyBullet is not available for all versions of Python."""

from __future__ import annotations

import functools
import importlib.util

from swarm_common.model.errors import ConfigError

BULLET, PLANAR = "bullet", "planar"
NO_WHEELS = (
    "PyBullet is not installed (PyPI has it ready for Python 3.11 only): robots drive planar, as"
    " with --drive planar"
)


@functools.cache
def usual_engine() -> str:
    """Return ``bullet`` where PyBullet is installed, else ``planar``."""
    return BULLET if importlib.util.find_spec("pybullet") is not None else PLANAR


def check_engine(engine: str | None, asked: str) -> None:
    """Refuse an engine that is not installed.

    Args:
        engine: Name; None for the usual one.

    Raises:
        ConfigError: If PyBullet is asked for and is not there.
    """
    if engine == BULLET != usual_engine():
        raise ConfigError(f"{asked}: {NO_WHEELS}; README tells how to have it")

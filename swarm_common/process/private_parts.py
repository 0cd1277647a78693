"""Parts of libraries that are private to them: a version that moved one is told in plain words."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterable
from typing import Any

from swarm_common.model.errors import SwarmError


class MovedPartError(SwarmError):
    """An installed library lacks a private part that one of our modules uses."""


def require(distribution: str, user: str, parts: Iterable[tuple[Any, str]]) -> None:
    """Check that a library has the private parts that we use.

    Args:
        parts: Owner and name of each: an attribute of the owner, or an attribute that the code
            of the owner, a function, sets.

    Raises:
        MovedPartError: For the first part that is missing; names library, version and part.
    """
    for owner, name in parts:
        code = getattr(owner, "__code__", None)
        if not (hasattr(owner, name) or (code is not None and name in code.co_names)):
            where = getattr(owner, "__qualname__", getattr(owner, "__name__", repr(owner)))
            version = importlib.metadata.version(distribution)
            raise MovedPartError(
                f"{distribution} {version} has no {where}.{name}, a private part that {user} uses:"
                f" install another version of {distribution}, or adapt {user}"
            )

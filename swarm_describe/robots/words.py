"""Words in the names of links, joints, plugins and controllers.

A name is split at everything that is no letter, between `aB` and `ABc`, and at digits: `controller`
holds no `roller`, and `omnicorp` no `omni`.
"""

from __future__ import annotations

import re

WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
# Words that start like this mean it whatever follows (castors, casterwheel); the others only alone.
PASSIVE_STARTS = ("caster", "castor", "idler", "freewheel")
PASSIVE = frozenset(("free", "passive"))
OMNI_STARTS = ("mecanum", "swedish", "omniwheel", "omnidirectional", "holonomic")
OMNI = frozenset(("omni", "roller", "rollers"))


def words(name: str) -> tuple[str, ...]:
    """Return the words of a name in lower case, in order."""
    return tuple(word.lower() for word in WORD.findall(name))


def is_passive(name: str) -> bool:
    """Return whether a name says that a wheel is not driven."""
    return any(word in PASSIVE or word.startswith(PASSIVE_STARTS) for word in words(name))


def is_omni(name: str) -> bool:
    """Return whether a name says that something rolls sideways, too."""
    return any(word in OMNI or word.startswith(OMNI_STARTS) for word in words(name))

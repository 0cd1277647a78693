"""A version of a library in which a private part moved is told in plain words."""

from __future__ import annotations

from types import ModuleType

import pytest

from swarm_common.middleware import rclpy_compat
from swarm_common.process import numba_compat
from swarm_common.process.private_parts import MovedPartError, require
from swarm_common.robots import xacro_compat
from swarm_view.scene import viser_compat

COMPATS = (
    ("numba", numba_compat),
    ("ros-jazzy-rclpy", rclpy_compat),
    ("viser", viser_compat),
    ("xacro", xacro_compat),
)


@pytest.mark.parametrize(("library", "compat"), COMPATS, ids=[name for name, _ in COMPATS])
def test_the_installed_version_has_every_part(library: str, compat: ModuleType) -> None:
    require(library, compat.__name__, compat.PARTS)


@pytest.mark.parametrize(("library", "compat"), COMPATS, ids=[name for name, _ in COMPATS])
def test_a_part_that_moved_is_named_with_the_version(library: str, compat: ModuleType) -> None:
    owner, _ = compat.PARTS[0]
    with pytest.raises(MovedPartError) as caught:
        require(library, compat.__name__, [*compat.PARTS, (owner, "_moved_elsewhere")])
    for word in (f"{library} ", f"has no {owner.__name__}._moved_elsewhere", compat.__name__):
        assert word in str(caught.value)


def test_an_attribute_that_a_constructor_no_longer_sets_is_a_moved_part() -> None:
    class Library:
        def __init__(self) -> None:
            self._kept = 1

    require("viser", "ours", [(Library.__init__, "_kept")])
    with pytest.raises(MovedPartError, match=r"Library.__init__\._gone"):
        require("viser", "ours", [(Library.__init__, "_gone")])

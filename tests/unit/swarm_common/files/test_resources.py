"""Paths are paths, and `file://` URLs are URLs."""

from pathlib import Path

import pytest

from swarm_common.files.resources import file_of
from swarm_describe.files.packages import PackageFinder

NAMES = ["a#b.stl", "a;b.stl", "a?b.stl", "a%20b.stl", "a b.stl", "~a.stl", "ä.stl"]


@pytest.mark.parametrize("name", NAMES)
def test_paths_urls_and_meshes_may_have_any_name(tmp_path, name):
    path = tmp_path / name
    assert file_of(str(path)) == path
    assert file_of(name) == Path(name)
    assert file_of(path.as_uri()) == path
    assert file_of(path.as_uri().replace("file://", "file://localhost")) == path
    path.touch()
    assert file_of(f"file://{path}") == path  # that nobody quoted
    share = tmp_path / "acme_description"
    share.mkdir()
    (share / name).touch()
    finder = PackageFinder([tmp_path])
    for uri in (f"package://acme_description/{name}", (share / name).as_uri(), name):
        assert finder.resolve(uri, share) == share / name

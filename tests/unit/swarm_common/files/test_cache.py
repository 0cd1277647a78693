"""What is kept between runs."""

from pathlib import Path

import pytest

from swarm_common.files import storage
from swarm_common.files.storage import kept
from swarm_describe.robots import description as robot_model
from swarm_describe.robots.loading import open_robot


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "swarm-workbench"


def test_only_the_first_call_makes_it(folder):
    calls = []

    def make():
        calls.append(1)
        return {"a": 1}

    assert kept("things", ["a", b"b"], make) == kept("things", ["a", b"b"], make) == {"a": 1}
    assert len(calls) == 1
    kept("things", ["ab", b""], make)  # other parts, though the same letters
    assert len(calls) == 2


def test_what_cannot_be_used_is_made_anew(folder, tmp_path, monkeypatch):
    kept("things", ["a"], lambda: list(range(100)))
    (file,) = (folder / "things").iterdir()
    file.write_bytes(file.read_bytes()[:50])
    assert kept("things", ["a"], lambda: [1]) == [1]
    assert kept("things", ["a"], lambda: [2]) == [1]
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert kept("things", ["a"], lambda: 3) == 3


def test_the_oldest_go(folder, monkeypatch):
    monkeypatch.setattr(storage, "MOST_KEPT", 2)
    for number in range(4):
        kept("things", [str(number)], lambda: 0)
    assert len(list((folder / "things").iterdir())) == 2


def test_a_robot_with_meshes_is_read_each_time(folder, tmp_path):
    (tmp_path / "hull.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    text = open_robot("turtlebot3_waffle").urdf.replace(
        "<collision",
        '<collision><geometry><mesh filename="hull.obj"/></geometry></collision><collision',
        1,
    )
    robot_model.parse_urdf(text, "robot.urdf", directory=Path(tmp_path))
    assert len(list((folder / "robots").iterdir())) == 1  # the waffle itself

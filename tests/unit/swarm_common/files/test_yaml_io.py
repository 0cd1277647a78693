"""YAML files that would never end: aliases of aliases, files of any size, pipes."""

import os
import threading

import pytest

from swarm_common.files import yaml_io
from swarm_common.files.yaml_io import parse_yaml, read_yaml, yaml_nodes
from swarm_common.model.errors import ConfigError

LAUGHS = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]\n" for n in range(1, 9)
)
MERGES = "a0: &a0 {x: 1}\n" + "".join(
    f"a{n}: &a{n} {{<<: [{', '.join([f'*a{n - 1}'] * 10)}]}}\n" for n in range(1, 9)
)
ITSELF = "/**: &a\n  ros__parameters: *a\n"


@pytest.mark.parametrize("text", [LAUGHS, MERGES, ITSELF], ids=["lists", "merges", "itself"])
def test_aliases_that_would_never_end_are_refused(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"mine.yaml, line \d+: .* aliases"):
        read_yaml(path)


def test_a_few_aliases_and_the_largest_integers_of_ros_are_read(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("a: &a {x: 1}\nb: {<<: *a, y: 2}\nc: [*a, *a]\n", encoding="utf-8")
    assert read_yaml(path) == {"a": {"x": 1}, "b": {"x": 1, "y": 2}, "c": [{"x": 1}, {"x": 1}]}
    path.write_text(f"a: {2**63 - 1}\nb: {-(2**63)}\n", encoding="utf-8")
    assert read_yaml(path) == {"a": 2**63 - 1, "b": -(2**63)}


def test_a_file_of_any_size_is_refused_before_it_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(yaml_io, "LONGEST", 1_000_000)
    path = tmp_path / "mine.yaml"
    with path.open("wb") as file:
        file.truncate(10**12)
    with pytest.raises(ConfigError, match=r"mine.yaml has more than 1 MB"):
        read_yaml(path)


def test_a_pipe_is_read_to_its_end(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=("a: 1\r\n",))
    writer.start()
    assert read_yaml(pipe) == {"a": 1}
    writer.join()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (f"a: {'9' * 400}", "line 1: malformed YAML: an integer of more than 64 bits"),
        (f"a: 1\nb: -0x{'f' * 17}", "line 2: malformed YAML: an integer of more than 64 bits"),
        ("a: 1\nb: gr\xfc\xdfe", "line 2: it is not UTF-8; save it as UTF-8"),
        ("a: 1\nb: \0", "unacceptable character"),
    ],
    ids=["digits", "hexadecimal", "latin", "zero"],
)
def test_what_no_parameter_can_be_is_one_line_that_says_where(tmp_path, content, message):
    path = tmp_path / "mine.yaml"
    path.write_bytes(content.encode("latin-1"))
    with pytest.raises(ConfigError, match=message) as caught:
        read_yaml(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["wiat:\t1\n", "a:\n  wiat:\t{b: 1}\n", "wi\tat: 1\n"])
def test_what_was_read_has_nodes_with_lines(text):
    """Two readers of YAML take tabs differently: the one that had not read it raised raw errors."""
    assert isinstance(parse_yaml(text, "f"), dict)
    assert yaml_nodes(text).start_mark.line == 0

"""Parameter files as rcl reads them: nesting, wildcards, what is given twice."""

import pytest

from swarm_common.files.params_io import is_for, read_parameter_file
from swarm_common.model.errors import ConfigError


def read(folder, text):
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return read_parameter_file(path)


@pytest.mark.parametrize(
    "head",
    [
        "/Srobot1/navigator: {%s}",
        "Srobot1/navigator: {%s}",
        "Srobot1: {navigator: {%s}}",
        "/Srobot1: {navigator: {%s}}",
    ],
)
def test_every_nesting_is_the_same_node(tmp_path, head):
    text = head % "ros__parameters: {max_vel_x: 0.1, holding: {mode: park}}"
    wanted = {"max_vel_x": 0.1, "holding.mode": "park"}
    assert read(tmp_path, text) == {"/Srobot1/navigator": wanted}


def test_a_namespace_may_hold_nodes_and_wildcards_in_order(tmp_path):
    text = (
        "/**: {ros__parameters: {a: 1}, navigator: {ros__parameters: {a: 2}}}\n"
        "fleet: {'*': {navigator: {ros__parameters: {a: 3}}}}\n"
    )
    found = read(tmp_path, text)
    assert found == {"/**": {"a": 1}, "/**/navigator": {"a": 2}, "/fleet/*/navigator": {"a": 3}}


@pytest.mark.parametrize(
    ("pattern", "node", "wanted"),
    [
        ("/**", "/Srobot1/navigator", True),
        ("/**/navigator", "/a/b/navigator", True),
        ("/**/navigator", "/navigator", True),
        ("/*", "/Srobot1/navigator", False),
        ("*", "/Srobot1/navigator", False),
        ("/*/navigator", "/a/b/navigator", False),
        ("/*/*", "/Srobot1/navigator", True),
        ("/Srobot1/*", "/Srobot12/navigator", False),
        ("/Srobot1/navigator", "/Srobot1/navigator", True),
        ("/Srobot1", "/Srobot1/navigator", False),
        ("navigator", "/Srobot1/navigator", True),
        ("/Srobot.*/navigator", "/Srobot1/navigator", False),
    ],
)
def test_wildcards_are_those_of_rcl(pattern, node, wanted):
    assert is_for(pattern, node) is wanted


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("/a: {ros__parameters: {x: 1}}\na: {ros__parameters: {x: 2}}", "/a: .*'x' is given twice"),
        ("/a: {ros__parameters: {x.y: 1, x: {y: 2}}}", "'x.y' is given twice"),
        ("ros__parameters: {x: 1}", "stands below no node"),
        ("/a: {ros__parameters: [1]}", "expected parameters in the section"),
        ("/a: {b: {x: 1}}", "/a/b/x: expected a section 'ros__parameters:'"),
        ("/a: {}", "expected a section"),
        ("/a: {ros__parameters: {x: 1}, y: 2}", "unknown key 'y'"),
    ],
)
def test_what_has_no_place_is_refused(tmp_path, text, message):
    with pytest.raises(ConfigError, match=message):
        read(tmp_path, text)

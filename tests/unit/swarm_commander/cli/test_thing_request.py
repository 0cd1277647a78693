"""What `swarm-commander spawn` asks for when a thing is to come."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from swarm_commander.cli.thing_request import GROUND, thing_request
from swarm_common.model.errors import ConfigError

PLACE = (1.0, 2.0, 0.5)


def test_boxes_and_cylinders_become_models_and_files_are_named_for_the_world(tmp_path, monkeypatch):
    request = thing_request("crate", "", (0.5, 0.4, 0.6), None, 3.0, PLACE)
    assert (request.name, request.allow_renaming) == ("crate", False)
    assert request.initial_pose.header.frame_id == GROUND
    root = ET.fromstring(request.resource_string)
    assert root.findtext("model/static") == "false"
    assert root.findtext(".//mass") == "3.0"
    assert root.findtext(".//size") == "0.5 0.4 0.6"
    request = thing_request("", "", None, (0.2, 1.0), None, PLACE)
    assert request.allow_renaming
    root = ET.fromstring(request.resource_string)
    assert root.findtext("model/static") == "true"
    assert root.findtext(".//radius") == "0.2"
    monkeypatch.chdir(tmp_path)
    Path("shelf.sdf").touch()
    request = thing_request("", "shelf.sdf", None, None, None, PLACE)
    assert request.uri == str(Path("shelf.sdf").absolute())
    request = thing_request("", "model://shelf", None, None, None, PLACE)
    assert request.uri == "model://shelf"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("", "a.sdf", (1.0, 1.0, 1.0), None, None, PLACE), "exclude each other"),
        (("", "", (1.0, 1.0, 1.0), None, None, None), "--pose"),
        (("", "a.sdf", None, None, 2.0, PLACE), "--mass"),
        (("", "", (1.0, -1.0, 1.0), None, None, PLACE), "positive"),
        (("", "", None, (0.1, float("nan")), None, PLACE), "positive"),
    ],
)
def test_contradictions_are_refused(arguments, words):
    with pytest.raises(ConfigError, match=words):
        thing_request(*arguments)

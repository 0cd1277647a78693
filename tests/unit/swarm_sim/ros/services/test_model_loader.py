"""Models that hold their reader up, kill it or are too large end with an answer."""

import os
import time
from pathlib import Path

import pytest

from swarm_common.process.standard_streams import LONGEST_MESSAGE, shown
from swarm_describe.robots.loading import Robot
from swarm_describe.worlds.scene import Body
from swarm_sim.ros.services.model_loader import ModelLoader
from swarm_sim.world.model_reader import Model, ModelRequest, read_model
from swarm_sim.world.request_checks import Reason, RefusedError

BOX = "<geometry><box><size>0.4 0.4 0.4</size></box></geometry>"


def sdf(links=1, size="0.4 0.4 0.4", pose="0 0 0 0 0 0"):
    inner = "".join(
        f'<link name="l{i}"><pose>{pose}</pose><collision name="c">'
        f"{BOX.replace('0.4 0.4 0.4', size)}</collision></link>"
        for i in range(links)
    )
    return f'<sdf version="1.7"><model name="crate">{inner}</model></sdf>'


def urdf(joints):
    links = "".join(f'<link name="l{i}"/>' for i in range(joints + 1))
    chain = "".join(
        f'<joint name="j{i}" type="fixed"><parent link="l{i}"/><child link="l{i + 1}"/></joint>'
        for i in range(joints)
    )
    return f'<robot name="chain">{links}{chain}</robot>'


def request(uri="", text=""):
    return ModelRequest(uri, text, False, Path())


def refusal(asked):
    with pytest.raises(RefusedError) as caught:
        read_model(asked)
    return caught.value


def answers(loader, count, limit=60.0):
    found: list[Model | RefusedError] = []
    end = time.monotonic() + limit
    while len(found) < count:
        assert time.monotonic() < end, found
        before = time.monotonic()
        found += [model for _, model in loader.poll()]
        assert time.monotonic() - before < 3.0  # the world's tick goes on meanwhile
        time.sleep(0.01)
    return found


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (sdf(10_000), "10000 collision shapes"),
        (sdf(size="999 1 1"), "from its frame"),
        (sdf(pose="9e3 0 0 0 0 0"), "from its frame"),
        (urdf(100_000), "100001 links"),
        ("<sdf" * 100_000, "malformed"),
        ("<a>" * 100_000 + "</a>" * 100_000, "outermost"),
    ],
)
def test_what_is_too_large_is_refused(text, words):
    error = refusal(request(text=text))
    assert words in str(error)
    assert len(str(error)) <= 2 * LONGEST_MESSAGE


@pytest.mark.parametrize("uri", ["x" * 5000, "file:///" + "x" * 300, "model://" + "../" * 1000])
def test_uris_that_are_no_files_are_refused(uri):
    assert refusal(request(uri)).reason in (Reason.NO_MODEL, Reason.BAD_MODEL)


@pytest.mark.parametrize("suffix", [".sdf", ".urdf", ""])
def test_a_fifo_and_a_device_are_no_models(tmp_path, suffix):
    fifo = tmp_path / f"pipe{suffix}"
    os.mkfifo(fifo)
    for uri in (str(fifo), f"file://{fifo}", "/dev/zero"):
        error = refusal(request(uri))
        assert error.reason is Reason.NO_MODEL
        assert "no regular file" in str(error)
    large = tmp_path / f"large{suffix}"
    with large.open("wb") as file:
        file.truncate(1 << 40)  # a sparse file
    assert "bytes" in str(refusal(request(str(large))))


def test_messages_are_fit_to_be_shown():
    text = shown("a\x1b[2J" + "x" * 10_000_000 + "\0end")
    assert text.isprintable()
    assert text.startswith("a?[2J")
    assert text.endswith("end")
    assert len(text) < 2 * LONGEST_MESSAGE


def test_the_reader_answers_in_order_and_outlives_what_is_refused():
    loader = ModelLoader()
    try:
        asked = [
            request(text=sdf()),
            request("turtlebot3_burger"),
            request("turtlebot9"),
            request(text="<sdf"),
            request(text=sdf(10_000)),
            request(text=sdf()),
        ]
        for each in asked:
            loader.ask(each, each)
        first, robot, unknown, broken, large, last = answers(loader, len(asked))
        assert isinstance(first, Body)
        assert isinstance(last, Body)
        assert isinstance(robot, Robot)
        for error in (unknown, broken, large):
            assert isinstance(error, RefusedError)
            assert error.reason is Reason.BAD_MODEL
    finally:
        loader.close()


def test_a_model_that_takes_for_ever_costs_only_its_reader(tmp_path):
    mesh = tmp_path / "pipe.stl"
    os.mkfifo(mesh)
    stuck = tmp_path / "stuck.sdf"
    box, uri = "<box><size>0.4 0.4 0.4</size></box>", f"<mesh><uri>{mesh}</uri></mesh>"
    stuck.write_text(sdf().replace(box, uri), encoding="utf-8")
    loader = ModelLoader(limit=15.0)
    try:
        loader.ask("stuck", request(str(stuck)))
        loader.ask("fine", request(text=sdf()))
        error, fine = answers(loader, 2)
        assert isinstance(error, RefusedError)
        assert isinstance(fine, Body)
    finally:
        loader.close()

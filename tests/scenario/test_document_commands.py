"""What the documents tell a reader to type works: their marked blocks are run, in their order."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from tests.document_blocks import blocks_of
from tests.fakes.ros_domains import reserved_domain

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 400.0  # [s] of wall time for a block
START = 60.0  # [s] of wall time for a swarm
STOP = 60.0  # [s] likewise
BLOCKS = {
    path: blocks
    for path in sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
    if (blocks := list(blocks_of(path.read_text("utf-8"))))
}


def documents(*kinds):
    return [
        pytest.param(path, id=str(path.relative_to(ROOT)))
        for path, blocks in BLOCKS.items()
        if any(block.kind in kinds for block in blocks)
    ]


def environment(folder, domain):
    (folder / ".venv").symlink_to(sys.prefix)
    path = f"{Path(sys.prefix) / 'bin'}:{os.environ['PATH']}"
    return os.environ | {"PATH": path, "ROS_DOMAIN_ID": str(domain)}


def shell(block, folder, env):
    with subprocess.Popen(
        ["bash", "-euo", "pipefail", "-c", block.text],
        cwd=folder, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
    ) as commands:  # fmt: skip
        try:
            output, _ = commands.communicate(timeout=LIMIT)
        finally:  # what a command leaves behind ends with it
            with suppress(ProcessLookupError):
                os.killpg(commands.pid, signal.SIGKILL)
    assert commands.returncode == 0, f"line {block.line}:\n{block.text}\n{output}"


@contextmanager
def background(block, folder, env):
    """Keep a swarm running, and stop it as a reader does, by Ctrl-C."""
    log = folder / "background.log"
    with log.open("w", encoding="utf-8") as output:
        swarm = subprocess.Popen(
            ["bash", "-euo", "pipefail", "-c", block.text],
            cwd=folder, env=env, stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
    try:
        end = time.monotonic() + START
        while "all robots are active" not in log.read_text(encoding="utf-8"):
            assert time.monotonic() < end, log.read_text(encoding="utf-8")
            assert swarm.poll() is None, log.read_text(encoding="utf-8")
            time.sleep(0.2)
        yield
        os.killpg(swarm.pid, signal.SIGINT)
        assert swarm.wait(STOP) == 0, log.read_text(encoding="utf-8")
    finally:
        if swarm.poll() is None:
            os.killpg(swarm.pid, signal.SIGKILL)
            swarm.wait(STOP)


def play(document, folder, kinds):
    with reserved_domain() as domain:
        env = environment(folder, domain)
        blocks = iter([block for block in BLOCKS[document] if block.kind in (*kinds, "save")])
        _play(blocks, folder, env)


def _play(blocks, folder, env):
    for block in blocks:
        if block.kind == "save":
            (folder / block.name).write_text(block.text, encoding="utf-8")
        elif block.kind == "background":
            with background(block, folder, env):
                _play(blocks, folder, env)
        else:
            shell(block, folder, env)


@pytest.mark.slow
@pytest.mark.timeout(500)
@pytest.mark.parametrize("document", documents("run"))
def test_the_short_blocks_of_a_document_run(document, tmp_path):
    play(document, tmp_path, ("run",))


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("document", documents("long", "background"))
def test_all_marked_blocks_of_a_document_run(document, tmp_path):
    play(document, tmp_path, ("run", "long", "background"))

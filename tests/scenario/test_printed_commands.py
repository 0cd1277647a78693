"""Commands that `swarm-map` prints, run as a user runs them."""

import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.fakes.programs import run_program

BIN = Path(sys.executable).parent
MAP = "image: {0}.png\nresolution: 0.1\norigin: [30, -40, 0]\n"


def run(words, folder):
    done = run_program([str(BIN / words[0]), *words[1:]], cwd=folder)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("name", "options"),
    [
        pytest.param(
            "plan", ["--origin", "30", "-40", "--resolution", "0.1"], marks=pytest.mark.long
        ),
        ("my plan", ["--origin", "3", "4", "--resolution", "0.1"]),
        pytest.param("hall_12", ["--resolution", "0.1"], marks=pytest.mark.long),  # it ships
        ("site", []),
    ],
)
def test_the_printed_command_starts_robots(tmp_path, name, options):
    pixels = np.full((80, 120), 255, np.uint8)
    pixels[[0, -1]], pixels[:, [0, -1]] = 0, 0
    pixels[40:44, 20:60] = 0
    Image.fromarray(pixels).save(tmp_path / f"{name}.png")
    plan = f"{name}.png"
    if not options:
        plan = f"{name}.yaml"
        (tmp_path / plan).write_text(MAP.format(name))
    code, said = run(["swarm-map", "new", plan, *options], tmp_path)
    assert code == 0, said
    command = shlex.split(said.partition("start robots with")[2])
    more = ["--headless", "--duration", "1", "--run-dir", "run"]
    code, said = run([*command, *more], tmp_path)
    assert code == 0, said
    report = (tmp_path / "run" / "report.json").read_text()
    assert name != "hall_12" or '"world": "./hall_12"' in report

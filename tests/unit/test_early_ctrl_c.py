"""Ctrl-C while a command still imports its modules: no traceback, and the shell sees 130."""

import signal
import sys
import tomllib
from pathlib import Path

import pytest

from tests.fakes.programs import run_program

FOLDER = Path(__file__).resolve().parents[2]
SCRIPTS = tomllib.loads((FOLDER / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "scripts"
]
# Names the modules that a door imports, then presses Ctrl-C at each import that follows.
PROGRAM = """
import os, signal, sys, typing
from importlib.machinery import PathFinder
before = set(sys.modules)
import {module}
print(*sorted(set(sys.modules) - before), flush=True)
class Finder(PathFinder):
    @classmethod
    def find_spec(cls, *_):
        os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder)
{module}.{function}()
"""


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_command_ends_quietly_while_it_imports(name):
    """It was a traceback through typer, numpy or importlib.metadata."""
    module, _, function = SCRIPTS[name].partition(":")
    done = run_program(
        [sys.executable, "-c", PROGRAM.format(module=module, function=function), "--help"]
    )
    doors = {"__future__", "swarm_commander.cli", "swarm_run", "swarm_run.command_line"}
    doors |= {module, module.partition(".")[0]}
    assert set(done.stdout.split()) <= doors
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "")

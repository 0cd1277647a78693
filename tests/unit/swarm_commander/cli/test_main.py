"""Around a command: closed streams, a deleted folder, variables that it cannot work with."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMAND = (sys.executable, "-c", "from swarm_commander.cli.main import swarm_up; swarm_up()")
FOLDER = Path(__file__).resolve().parents[4]


def test_closed_streams_are_no_failure():
    """It was a traceback where stdout was closed, and silence where all were."""
    for closed in (">&-", "2>&-", "<&- >&- 2>&-"):
        for flag in ("--list", "--version"):
            script = f'cd {FOLDER}; "$@" {flag} {closed}'
            done = subprocess.run(
                ["sh", "-c", script, "sh", *COMMAND], capture_output=True, check=False, timeout=60
            )
            assert done.returncode == 0, done.stderr


def test_a_deleted_folder_is_named(tmp_path):
    gone = tmp_path / "gone"
    gone.mkdir()
    script = 'cd "$0"; rmdir "$0"; "$@"'
    done = subprocess.run(
        ["sh", "-c", script, str(gone), *COMMAND, "--list"],
        env=os.environ | {"PYTHONPATH": str(FOLDER)},
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.startswith("swarm-up: the current folder cannot be used")


@pytest.mark.parametrize(("value", "code"), [("1", 2), ("0", 0), ("", 0)])
def test_without_a_compiler_nothing_starts(value, code):
    done = subprocess.run(
        [*COMMAND, "--list"],
        env=os.environ | {"NUMBA_DISABLE_JIT": value, "PYTHONPATH": str(FOLDER)},
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert done.returncode == code
    assert ("NUMBA_DISABLE_JIT is set" in done.stderr) is (code == 2)

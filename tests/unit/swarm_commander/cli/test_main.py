"""Around a command: closed streams, a deleted folder, variables that it cannot work with."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.fakes.programs import run_program

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
    done = run_program(["sh", "-c", script, str(gone), *COMMAND, "--list"])
    assert done.returncode == 2
    assert done.stderr.startswith("swarm-up: the current folder cannot be used")


@pytest.mark.parametrize(("value", "code"), [("1", 2), ("0", 0), ("", 0)])
def test_without_a_compiler_nothing_starts(value, code):
    done = run_program([*COMMAND, "--list"], {"NUMBA_DISABLE_JIT": value})
    assert done.returncode == code
    assert ("NUMBA_DISABLE_JIT is set" in done.stderr) is (code == 2)


@pytest.mark.parametrize("words", [["-h"], ["spawn", "-h"]])
def test_h_is_help(words):
    program = "from swarm_commander.cli.main import commander; commander()"
    done = run_program([sys.executable, "-c", program, *words])
    assert done.returncode == 0, done.stderr
    assert "Usage: swarm-commander" in done.stdout


def test_letters_that_the_terminal_lacks_are_no_failure():
    code = """
from swarm_common.process.standard_streams import open_standard_streams
open_standard_streams()
print("h\\u00e4lle", "\\udcff")
"""
    done = run_program([sys.executable, "-c", code], {"PYTHONIOENCODING": "ascii"})
    assert done.stdout == "h?lle ?\n", done.stderr


def test_signals_that_the_parent_had_changed_are_usual_ones():
    """Where SIGCHLD is ignored a world that crashed seemed to have ended with exit code 0."""
    code = """
import signal, subprocess, typer
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
from swarm_run.command_line import run_app
app = typer.Typer()
@app.command()
def look() -> None:
    print(subprocess.run("false").returncode, len(signal.pthread_sigmask(signal.SIG_BLOCK, ())))
run_app("look", lambda: app)
"""
    done = run_program([sys.executable, "-c", code])
    assert done.stdout == "1 0\n", done.stderr


def test_warnings_of_libraries_end_no_command():
    """A run ended with a traceback: a library imports a module that is deprecated."""
    done = run_program([*COMMAND, "--list"], {"PYTHONWARNINGS": "error"})
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("swarm-up: not used: PYTHONWARNINGS=error")
    assert done.stderr.count("\n") == 1


def test_a_message_has_no_control_characters(tmp_path):
    (tmp_path / "mine.yaml").write_text('"\\e[31mred": 1\n', encoding="utf-8")
    done = run_program([*COMMAND, "--params", "mine.yaml"], cwd=tmp_path)
    assert done.returncode == 2
    assert "mine.yaml: /?[31mred" in done.stderr


@pytest.mark.parametrize("text", ["raise RuntimeError('of another')", "nothing = 0"])
def test_a_module_of_the_user_that_hides_one_of_ours_is_named(tmp_path, text):
    """It was a traceback with the exit code of a missed goal."""
    (tmp_path / "yaml.py").write_text(text, encoding="utf-8")
    done = run_program([*COMMAND, "--list"], {"PYTHONPATH": f"{tmp_path}:{FOLDER}"})
    assert done.returncode == 3
    assert done.stderr.splitlines()[-1] == (
        f"{tmp_path / 'yaml.py'}, on PYTHONPATH, hides the yaml that is needed: unset PYTHONPATH"
    )

"""A command says the truth where its output leads nowhere: full, closed, not read any more."""

import sys

import pytest

from tests.fakes.programs import run_program

MAIN = "import sys; from swarm_commander.cli import main; main.{}()"
COMMANDS = {
    "ros2": ("-m", "swarm_ros2", "interface", "show", "std_msgs/msg/Header"),
    "ros2 help": ("-m", "swarm_ros2", "topic", "--help"),
    "version": ("-c", MAIN.format("swarm_up"), "--version"),
    "table": ("-c", MAIN.format("swarm_up"), "--list"),
    "help": ("-c", MAIN.format("report"), "--help"),
}


def ended(name, redirection, *more, unbuffered=""):
    done = run_program(
        ["bash", "-c", f'"$@" {redirection}', "bash", sys.executable, *COMMANDS[name], *more],
        {"PYTHONUNBUFFERED": unbuffered},
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize("name", COMMANDS)
def test_output_on_a_full_disk_is_a_failure_told_in_a_line(name):
    """It was a traceback with exit code 1, or `Exception ignored in` and 120."""
    code, errors = ended(name, "> /dev/full")
    command = {"ros2": "ros2", "ros2 help": "ros2", "help": "swarm-report"}.get(name, "swarm-up")
    assert errors == f"{command}: cannot write the output: No space left on device\n"
    assert code == (1 if command == "ros2" else 3)


@pytest.mark.parametrize("name", ["ros2", "version", "table"])
def test_each_write_may_be_the_one_that_fails(name):
    assert "cannot write the output" in ended(name, "> /dev/full", unbuffered="1")[1]


@pytest.mark.parametrize("name", ["ros2", "table"])
def test_a_message_that_nobody_can_read_changes_no_exit_code(name):
    for redirection in ("2> /dev/full", "2>&-"):
        assert ended(name, redirection, "--nonsense")[0] == 2
        assert ended(name, f"> /dev/null {redirection}")[0] == 0

"""`swarm-bench` imports what the command that is asked for needs, and no other's."""

import subprocess
import sys

import typer

from swarm_bench.cli import HOMES, _load

SLOW = "matplotlib", "scipy.stats", "swarm_bench.capacity", "swarm_bench.study"
LOADED = (
    "import sys, typer; from swarm_bench.cli import _load;"
    "command = typer.main.get_command(_load(sys.argv[1:])).commands[sys.argv[1]];"
    "assert len(command.params) > 1; print(*sys.modules)"
)


def loaded(*words):
    command = [sys.executable, "-c", LOADED, *words]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def test_every_command_is_known():
    command = typer.main.get_command(_load())
    assert list(command.commands) == [*HOMES]


def test_a_command_is_loaded_without_the_others():
    assert not {*SLOW} & {*loaded("traffic", "--help")}
    assert not {"swarm_bench.lanes", "swarm_bench.study"} & {*loaded("sweep", "--robots", "4")}


def test_what_is_no_command_has_all_of_them_to_choose_from():
    script = "from swarm_bench.cli import main; main()"
    run = subprocess.run([sys.executable, "-c", script, "swep"], capture_output=True, text=True)
    assert run.returncode == 2
    assert "Did you mean 'sweep'" in run.stderr

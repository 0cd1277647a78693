"""`swarm-bench` imports what the command that is asked for needs, and no other's."""

import subprocess
import sys

from swarm_bench.cli import HOMES

SLOW = "matplotlib", "scipy.stats", "swarm_bench.capacity", "swarm_bench.study"
NAMES = (
    "import typer; from swarm_bench.cli import _load;"
    "print(*typer.main.get_command(_load()).commands)"
)
LOADED = (
    "import sys, typer; from swarm_bench.cli import _load;"
    "command = typer.main.get_command(_load(sys.argv[1:])).commands[sys.argv[1]];"
    "assert len(command.params) > 1; print(*sys.modules)"
)


def printed(script, *words):
    """Words that a script prints in a process of its own: imported modules stay imported."""
    command = [sys.executable, "-c", script, *words]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def test_every_command_is_known():
    assert printed(NAMES) == [*HOMES]


def test_a_command_is_loaded_without_the_others():
    assert not {*SLOW} & {*printed(LOADED, "traffic", "--help")}
    sweep = printed(LOADED, "sweep", "--robots", "4")
    assert not {"swarm_bench.lanes", "swarm_bench.study"} & {*sweep}


def test_what_is_no_command_has_all_of_them_to_choose_from():
    script = "from swarm_bench.cli import main; main()"
    run = subprocess.run([sys.executable, "-c", script, "swep"], capture_output=True, text=True)
    assert run.returncode == 2
    assert "Did you mean 'sweep'" in run.stderr

"""The process that runs a swarm for a program, and ends with it.

Its standard input brings the description of the run, and ends when the program does, however that
happens.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading

import typer

from swarm_commander.cli.session import start
from swarm_run.command_line import run_app
from swarm_run.domain import DomainLock
from swarm_run.spec import RunSpec


def _end_with(program: int) -> None:
    """End this process as Ctrl-C would when the program at the other end of a pipe is gone."""
    os.read(program, 1)  # no buffered stream: one that is locked aborts an interpreter that ends
    os.kill(os.getpid(), signal.SIGINT)


def main() -> int:
    """Run the swarm; return the exit code of `swarm-up`."""
    spec: RunSpec = pickle.load(sys.stdin.buffer)
    lock = DomainLock.of(int(sys.argv[2]))
    del sys.argv[1:]  # the first is the folder of the run, for people who list processes
    threading.Thread(target=_end_with, args=(sys.stdin.fileno(),), daemon=True).start()

    app = typer.Typer(add_completion=False)

    @app.command()
    def up() -> None:
        raise typer.Exit(start(spec, lock))

    return run_app("swarm-up", lambda: app)


if __name__ == "__main__":
    sys.exit(main())

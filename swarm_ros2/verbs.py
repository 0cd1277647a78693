"""How verbs are declared: their names, flags, and the options that several of them share."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

Run = Callable[[argparse.Namespace], None]
NODE = "Name of the ROS node"
LISTENED = "Name of the ROS topic to listen to (e.g. '/chatter')"


def add_verb(
    verbs: Any, name: str, summary: str, run: Run, **arguments: str
) -> argparse.ArgumentParser:
    """Add a verb that `run` executes to a command; `arguments` are names and help texts."""
    verb: argparse.ArgumentParser = verbs.add_parser(name, help=summary)
    verb.set_defaults(run=run)
    for argument, text in arguments.items():
        verb.add_argument(argument, help=text)
    return verb


def add_flag(parser: Any, *names: str, **settings: Any) -> None:
    """Add an option that takes no value to a parser or to a group of its options."""
    parser.add_argument(*names, action="store_true", **settings)


def add_list_options(verb: argparse.ArgumentParser, kind: str) -> None:
    """Add what the verbs that list or find topics or services have in common."""
    add_flag(verb, "-c", f"--count-{kind}s", help=f"Only display the number of {kind}s discovered")
    add_flag(verb, f"--include-hidden-{kind}s", help=f"Consider hidden {kind}s as well")

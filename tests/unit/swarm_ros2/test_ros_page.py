"""Every `ros2` command of docs/ros.md: its words fit, and a graph test uses its verb and its type.

The page's blocks are run by a shell in which programs only note how they were called. That they
do what the page says is tests/scenario/test_document_commands.py, with -m long.
"""

import argparse
import functools
import os
import re
import subprocess
import tempfile
from pathlib import Path

import typer

from swarm_commander.cli.main import load_app
from swarm_ros2 import command_line, text
from swarm_ros2.launcher import swarm_up_arguments
from tests.document_blocks import blocks_of

ROOT = Path(__file__).parents[3]
GRAPH_TESTS = "\n".join(p.read_text("utf-8") for p in (ROOT / "tests/graph").rglob("test_*.py"))
FIELDS = {  # where a command has a type, and what fills it
    ("service", "call"): ("srv", "service_type", "values"),
    ("action", "send_goal"): ("action", "action_type", "goal"),
    ("topic", "pub"): ("msg", "message_type", "values"),
}
NOTE = """#!/bin/bash
printf '%s\\0' "${0##*/}" "$@" $'\\1' >> "$NOTES"
"""
PROGRAMS = {
    "ros2": NOTE,
    "swarm-up": NOTE,
    "swarm-commander": NOTE,
    "grep": "#!/bin/sh\ncat > /dev/null\n",
    "timeout": '#!/bin/bash\nshift 2\nexec "$@"\n',
}


@functools.cache
def commands():
    """Return the page's commands as a shell calls them: loops, functions, variables resolved."""
    found = []
    with tempfile.TemporaryDirectory() as name:
        folder, notes = Path(name), Path(name) / "notes"
        (folder / "runs/latest").mkdir(parents=True)
        (folder / "runs/latest/env.sh").touch()
        for program, script in PROGRAMS.items():
            (folder / program).write_text(script)
            (folder / program).chmod(0o755)
        environ = os.environ | {"PATH": f"{folder}:{os.environ['PATH']}", "NOTES": str(notes)}
        for block in blocks_of((ROOT / "docs/ros.md").read_text("utf-8")):
            notes.write_text("")
            command = ("bash", "-euo", "pipefail", "-c", block.text)
            subprocess.run(command, cwd=folder, env=environ, check=True, capture_output=True)
            called = notes.read_text("utf-8").split("\0\1\0")[:-1]
            assert called, f"line {block.line}: nothing is called"
            found += [line.split("\0") for line in called]
    return found


def ros2_commands():
    return [words[1:] for words in commands() if words[0] == "ros2"]


def verbs_shown():
    """Return command and verb of each command of the page; programs have no verb."""
    return {(w[0], "" if w[0] in command_line.LIKE_PROGRAMS else w[1]) for w in ros2_commands()}


def parsed(words):
    return command_line._parser(words).parse_args(words)


def test_the_words_of_every_command_fit():
    up = typer.main.get_command(load_app("swarm-up"))
    for words in ros2_commands():
        options = parsed(words)
        if words[0] == "launch":
            up.make_context("swarm-up", swarm_up_arguments(options.arguments))


def test_the_values_of_every_request_fit_its_type():
    requests = [words for words in ros2_commands() if tuple(words[:2]) in FIELDS]
    assert len(requests) > 50
    for words in requests:
        kind, of_type, of_values = FIELDS[words[0], words[1]]
        options = parsed(words)
        message = text.load(kind, getattr(options, of_type))
        part = {"srv": "Request", "action": "Goal"}.get(kind)
        values = text.parse_values(getattr(options, of_values))
        text.fill(getattr(message, part)() if part else message(), values)


def test_a_graph_test_uses_every_verb_and_type_of_the_page():
    called = re.findall(r'(?="(\w+)",\s*"(\w+)")', GRAPH_TESTS)
    measured = [("topic", verb) for verb in re.findall(r'measure\("(\w+)"', GRAPH_TESTS)]
    assert {(name, verb) for name, verb in verbs_shown() if verb} - {*called, *measured} == set()
    words = {word for line in ros2_commands() for word in line}
    types = {
        word.rpartition("/")[2] for word in words if re.fullmatch(r"\w+/(msg|srv|action)/\w+", word)
    }
    assert len(types) > 40
    assert {name for name in types if not re.search(rf"\b{name}\b", GRAPH_TESTS)} == set()


def choices(parser):
    found = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    return dict(found[0].choices) if found else {}


def test_the_page_shows_every_verb_and_its_table_names_it():
    page = (ROOT / "docs/ros.md").read_text("utf-8")
    for name in command_line.COMMANDS:
        verbs = choices(choices(command_line._parser([name]))[name])
        shown = {verb for command, verb in verbs_shown() if command == name}
        assert shown == (verbs.keys() or {""})
        assert f"| {name} | {', '.join(sorted(verbs))}" in page


def test_the_page_calls_every_interface_of_its_table_of_simulation_interfaces():
    page = (ROOT / "docs/ros.md").read_text("utf-8")
    definitions = ROOT / "interfaces/simulation_interfaces"
    names = {path.stem for path in definitions.glob("*/*") if path.parent.name in ("srv", "action")}
    words = {word.rpartition("/")[2] for line in ros2_commands() for word in line}
    assert len(names) == 23
    assert names <= words
    rows = "".join(line.split("|")[1] for line in page.splitlines() if line.startswith("| "))
    assert {name for name in names if not re.search(rf"\b{name}\b", rows)} == set()

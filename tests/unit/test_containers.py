"""Dockerfile and compose.yaml: what linters say, and that the commands in them exist."""

import json
import re
import shlex
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import typer
import yaml

from swarm_commander.cli import main as commander_cli
from swarm_view import cli as view_cli
from tests.fakes.hosts.containers import ignore_patterns, interpolated, is_ignored, steps_of

ROOT = Path(__file__).parents[2]
BIN = Path(sys.executable).parent
APPS = {"swarm-up": partial(commander_cli.load_app, "swarm-up"), "swarm-view": view_cli.load_view}
SECRET = {"SWARM_SECRET": "of a test"}


def lint(*command):
    done = subprocess.run(
        [str(BIN / command[0]), *command[1:]], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def services(environment):
    file = yaml.safe_load((ROOT / "compose.yaml").read_text("utf-8"))
    return dict(interpolated(file, environment)["services"])


def test_dockerfile_and_compose_file_have_their_form():
    lint("hadolint", "Dockerfile")
    lint("check-jsonschema", "--builtin-schema", "vendor.compose-spec", "compose.yaml")
    for service in services(SECRET).values():
        assert (service["image"], service["build"]) == ("swarm-workbench", ".")
        assert service["environment"]["SWARM_SECRET"] == "of a test"


def test_the_context_has_what_the_image_needs_and_nothing_that_was_made_here():
    patterns = ignore_patterns(ROOT)
    files = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.splitlines()
    assert not [name for name in files if is_ignored(name.split("/")[0], patterns)]
    for made in (".git", ".venv", "runs", "swarm_sim/__pycache__", ".pytest_cache"):
        assert is_ignored(made, patterns)


def test_a_secret_has_to_be_given():
    with pytest.raises(KeyError, match="share a secret"):
        services({})


def commands(words):
    if words[:2] == ["bash", "-c"]:
        parts = [shlex.split(part) for part in words[2].split("&&")]
        return [part[part[0] == "exec" :] for part in parts if part[0] not in ("source", ".")]
    return [words]


def test_the_services_commands_and_options_exist():
    for service in services(SECRET).values():
        for words in commands(service["command"]):
            command: Any = typer.main.get_command(APPS[words[0]]())
            known = {name for item in command.params for name in (*item.opts, *item.secondary_opts)}
            used = {word.partition("=")[0] for word in words if word.startswith("--")}
            assert used <= known


def test_world_and_robots_agree_on_size_and_folders():
    wanted = services(SECRET | {"SWARM_SIZE": "24"})
    assert "--swarm-size=24" in wanted["world"]["command"]
    assert "--robots=1-24" in wanted["robots"]["command"]
    assert "--connect=world" in wanted["robots"]["command"]
    (workdir, *_) = [step.text for step in reversed(steps()) if step.verb == "WORKDIR"]
    for service in wanted.values():
        for volume in service["volumes"]:
            assert volume.split(":")[1] == f"{workdir}/runs"
    port = wanted["world"]["ports"][0]
    assert re.fullmatch(r"127\.0\.0\.1:(\d+):\1", port), "the viewer knows its links by its port"
    assert wanted["viewer"]["network_mode"] == "service:world"


def steps():
    return steps_of((ROOT / "Dockerfile").read_text("utf-8"))


def test_the_dockerfile_is_read_with_its_flags_and_continued_lines():
    text = (
        "FROM debian:12-slim AS a\n# no\nRUN one \\\n  && two\n"
        "COPY --from=a --chown=u:u /x /y\nCMD [\"z\"]\n"
    )  # fmt: skip
    assert [(step.verb, dict(step.flags), step.text.split()) for step in steps_of(text)] == [
        ("FROM", {}, ["debian:12-slim", "AS", "a"]),
        ("RUN", {}, ["one", "&&", "two"]),
        ("COPY", {"from": "a", "chown": "u:u"}, ["/x", "/y"]),
        ("CMD", {}, ["[\"z\"]"]),
    ]  # fmt: skip


def test_the_default_command_is_one_of_ours():
    (command,) = [json.loads(step.text) for step in steps() if step.verb == "CMD"]
    assert command[0] in APPS

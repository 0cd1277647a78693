"""Documents are true: their commands and options exist, and so does what they point to."""

import re
import shlex
import subprocess
import sys
import tomllib
from dataclasses import MISSING, fields
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import typer
import yaml

from benchmarks.__main__ import load as load_benchmarks
from swarm_bench import cli as bench_cli
from swarm_bench.runs.scenario import Scenario, load_scenario
from swarm_commander.cli import main as commander_cli
from swarm_common.model.records import LidarSpec
from swarm_common.model.robot_names import FLEET_COMMANDS
from swarm_map import cli as map_cli
from swarm_nav.core.states import MakingWay, diagram
from swarm_view import cli as view_cli
from tools.write_reference import pages

ROOT = Path(__file__).parents[2]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
DATED = ("CHANGELOG.md",)  # what was true then
SCRIPTS = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["scripts"]
LOADERS = {
    "swarm-up": partial(commander_cli.load_app, "swarm-up"),
    "swarm-teleop": partial(commander_cli.load_app, "swarm-teleop"),
    "swarm-report": partial(commander_cli.load_app, "swarm-report"),
    "swarm-replay": view_cli.load_replay,
    "swarm-doctor": partial(commander_cli.load_app, "swarm-doctor"),
    "swarm-setup": partial(commander_cli.load_app, "swarm-setup"),
    "swarm-bench": bench_cli._load,
    "swarm-map": map_cli._load,
    "swarm-view": view_cli.load_view,
    "benchmarks": load_benchmarks,  # python -m benchmarks
}
EXAMPLES = {"description", "actors", "dead", "seeds", "time_limit", "targets", "dispatch"}
OTHERS = {"ros2"}  # scripts that take no options of typer
FOLDERS = r"(?:docs|params|worlds|robots|maps|tests|tools|benchmarks|swarm_[a-z0-9]+)"
ENDINGS = r"(?:md|yaml|py|sdf|sh|png|svg|gif|webm|xml)"
MENTION = re.compile(rf"(?<![\w/.-]){FOLDERS}/[\w./-]*\w\.{ENDINGS}\b")
LINK = re.compile(r"\]\((?!https?://|#)([^)#]+)")


def texts():
    return [
        pytest.param(path, id=str(path.relative_to(ROOT)))
        for path in DOCUMENTS
        if path.name not in DATED
    ]


def command_lines(text):
    """Yield the commands of code blocks and of inline code, continued lines joined."""
    joined = text.replace("\\\n", " ")
    blocks = [line.strip() for line in joined.splitlines() if line.startswith("    ")]
    blocks += [line for fence in re.findall(r"```\w*\n(.*?)```", joined, re.S)
               for line in fence.splitlines()]  # fmt: skip
    for line in [*blocks, *re.findall(r"`((?:swarm-|python -m benchmarks)[^`]+)`", joined)]:
        code = re.sub(r"^(\.venv/bin/)?(python -m (?=benchmarks\b))?", "", line.strip())
        if not re.match(
            r"(swarm-[a-z]+(?!:)|benchmarks )\b", code
        ):  # with a colon: what a command prints
            continue
        try:
            yield shlex.split(code, comments=True)
        except ValueError:
            continue  # prose with an apostrophe


def options_of(words):
    """Return the options that a command line may have."""
    app = commander_app(words) if words[0] == "swarm-commander" else LOADERS[words[0]]()
    command: Any = typer.main.get_command(app)
    known = {"--help", "--version"}
    for word in words[1:]:
        known |= {name for item in command.params for name in (*item.opts, *item.secondary_opts)}
        if word in getattr(command, "commands", {}):
            command = command.commands[word]
    return known | {name for item in command.params for name in (*item.opts, *item.secondary_opts)}


def commander_app(words):
    from swarm_commander.cli.commander_command import commander_app
    from swarm_commander.cli.fleet_command import fleet_app

    return fleet_app if words[1:2] and words[1] in FLEET_COMMANDS else commander_app


@pytest.mark.parametrize("document", texts())
def test_commands_and_their_options_exist(document):
    wrong = []
    for words in command_lines(document.read_text("utf-8")):
        if words[0] not in {*SCRIPTS, *LOADERS}:
            wrong.append(words[0])
        elif words[0] not in OTHERS:
            used = {word.split("=")[0] for word in words[1:] if re.match(r"--[a-z]", word)}
            used = {word.split("/")[0].rstrip(".,;:") for word in used}
            wrong += [f"{words[0]} {option}" for option in used - options_of(words)]
    assert not wrong


@pytest.mark.parametrize("document", texts())
def test_files_that_are_named_exist(document):
    text = document.read_text("utf-8")
    named = {name for name in MENTION.findall(text) if "NAME" not in name}  # of a run
    linked = {str((document.parent / name).relative_to(ROOT)) for name in LINK.findall(text)}
    assert not [name for name in named | linked if not (ROOT / name).exists()]


def test_the_check_of_the_site_fails_at_a_link_that_leads_nowhere(tmp_path):
    """With --quiet, mkdocs does not count the warnings that --strict is about."""
    [command] = re.findall(r"\.venv/bin/mkdocs (build .*)", (ROOT / "Makefile").read_text("utf-8"))
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "index.md").write_text("[code](../setup.py)\n")
    (tmp_path / "mkdocs.yml").write_text("site_name: tiny\n")
    mkdocs = Path(sys.executable).with_name("mkdocs")
    run = subprocess.run([mkdocs, *command.split()], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 1, run.stderr


def test_the_state_diagrams_in_the_documents_are_the_automata():
    documents = ROOT / "docs" / "architecture"
    assert diagram() in (documents / "tick.md").read_text("utf-8")
    assert diagram(MakingWay) in (documents / "liveness.md").read_text("utf-8")


def yaml_block(document, first_key):
    text = (ROOT / "docs" / document).read_text("utf-8")
    blocks = re.findall(rf"```yaml\n({first_key}:.*?)```", text, re.S)
    assert len(blocks) == 1
    content: dict[str, Any] = yaml.safe_load(blocks[0])
    return content


def test_all_keys_of_a_lidar_and_their_defaults_are_told():
    told = yaml_block("robots.md", "lidar")["lidar"]
    defaults = {item.name: item.default for item in fields(LidarSpec)}
    assert told.keys() == defaults.keys()
    has_default = {name for name, value in defaults.items() if value is not MISSING}
    assert {name: told[name] for name in has_default} == {
        name: defaults[name] for name in has_default
    }


def test_all_keys_of_a_scenario_and_their_defaults_are_told(tmp_path):
    told = yaml_block("bench.md", "description")
    path = tmp_path / "told.yaml"
    path.write_text(yaml.safe_dump(told), "utf-8")
    loaded, default = load_scenario(str(path)), Scenario(name="default")
    assert told.keys() == {item.name for item in fields(Scenario)} - {"name"}
    for name in told.keys() - EXAMPLES:
        assert getattr(loaded, name) == getattr(default, name), name


def test_the_reference_is_what_the_commands_and_classes_say():
    for name, text in pages().items():
        on_disk = (ROOT / "docs" / "reference" / name).read_text("utf-8")
        assert on_disk == text, f"{name} is out of date: python -m tools.write_reference"


PAST = re.compile(
    r"\b(?=[0-9a-f]*[a-f])(?=[0-9a-f]*\d)[0-9a-f]{7,10}\b"  # a commit
    r"|older code|code of (?:now|then|today)|earlier runs"
    r"|\b(?:until|since) (?:[0-9a-f]{7,}|today)\b"
)
WHERE_COMMITS_BELONG = {"results.md"}  # in the line under each table


@pytest.mark.parametrize("document", texts())
def test_documents_say_what_holds_now(document):
    text = re.sub(r"```.*?```|`[^`\n]*`|https?://\S+", "", document.read_text("utf-8"), flags=re.S)
    if document.name not in WHERE_COMMITS_BELONG:
        assert not PAST.findall(text)


@pytest.mark.parametrize("document", texts())
def test_tables_are_whole_and_anchors_lead_somewhere(document):
    text = re.sub(r"```.*?```", "", document.read_text("utf-8"), flags=re.S)
    wrong = []
    for block in re.findall(r"(?:^\|.*\n)+", text + "\n", re.M):
        lines = block.splitlines()
        widths = {len(re.findall(r"(?<!\\)\|", re.sub(r"`[^`]*`", "", line))) for line in lines}
        if len(lines) < 2 or not re.fullmatch(r"\|[ :|-]+\|", lines[1]) or len(widths) > 1:
            wrong.append(lines[0])
    assert not wrong
    links = re.findall(r"\]\((?!https?://)([^)#\s]*)#([^)\s]+)\)", document.read_text("utf-8"))
    targets = [(document.parent / name if name else document, anchor) for name, anchor in links]
    lost = [
        f"{path.name}#{anchor}"
        for path, anchor in targets
        if path.suffix == ".md" and anchor not in anchors_of(path)
    ]
    assert not lost


def anchors_of(document):
    """Return the anchors of a document's headings, as GitHub and mkdocs make them."""
    text = re.sub(r"```.*?```", "", document.read_text("utf-8"), flags=re.S)
    found: set[str] = set()
    for heading in re.findall(r"^#+ (.+)$", text, re.M):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        found.add(re.sub(r"[\s-]+", "-", re.sub(r"[^\w\s-]", "", plain.lower())).strip("-"))
    return found


def test_the_documents_are_short():
    words = {path: len(path.read_text("utf-8").split()) for path in DOCUMENTS}
    assert sum(words.values()) <= 50_000
    assert words[ROOT / "CHANGELOG.md"] <= 1_500
    assert words[ROOT / "docs" / "architecture" / "decisions.md"] <= 2_000
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= 100

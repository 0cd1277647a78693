import copy
import json
import random

import pytest

from swarm_common.model.errors import ConfigError
from swarm_report.bottleneck import find_bottleneck
from swarm_report.document import merits
from swarm_report.judgement import breach_lines, judge
from swarm_report.measures import state_shares, station_use, throughput
from swarm_report.run import RunData
from swarm_report.run_list import RunList
from tests.fakes.run_folder import make_run

ODD: tuple[object, ...] = (
    None, True, -1, 1e308, -1e308, 10**400, float("nan"), float("inf"), "", "x" * 5000,
    "\x1b[31m", [], {}, [[[]]], "NaN", 2**64, "../..",
)  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    return make_run(tmp_path / "runs" / "one", robots=3, seconds=30, crash=True)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("goals", {"reached": "all"}, r"sent|reached"),
        ("goals", None, "goals"),
        ("collisions", {"robot_robot": -1, "robot_world": 0}, "robot_robot"),
        ("min_clearance", 1e308, "min_clearance"),
        ("failures", "none", "failures"),
        ("robots", {"Srobot1": {"distance": "far"}}, "robots"),
    ],
)
def test_a_report_that_was_changed_is_refused_with_file_and_key(folder, key, value, words):
    path = folder / "report.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {key: value}))
    with pytest.raises(ConfigError, match=rf"report\.json is damaged, or not ours: .*({words})"):
        RunData(folder)
    assert "unreadable" in RunList(folder.parent).page()


@pytest.mark.parametrize("text", ["", "{", "[]", '{"goals": NaN}', "[" * 100_000])
def test_a_report_that_is_none_is_no_run_without_a_verdict(folder, text):
    (folder / "report.json").write_text(text)
    with pytest.raises(ConfigError, match=r"report\.json is damaged"):
        RunData(folder)


def test_lines_of_the_trace_that_were_changed_are_left_out_and_counted(folder):
    whole = RunData(folder)
    path = folder / "trace" / "world.jsonl"
    lines = path.read_text().splitlines()
    lines[3] = lines[3].replace('"t":2', '"t":"two"')
    lines[5] = lines[5].replace('"x":[', '"x":[NaN,')
    path.write_text("\n".join(lines))
    run = RunData(folder)
    assert len(run.series.times) == len(whole.series.times) - 2
    assert run.left_out == {"trace/world.jsonl": 1}  # NaN is no JSON: that line was cut off


def test_whatever_is_in_the_files_all_is_worked_out_or_refused(folder):
    rng = random.Random(3)
    names = ("report.json", "config/world.json", "trace/world.jsonl", "trace/robots.jsonl")
    texts = {name: (folder / name).read_text() for name in (*names, "trace/usage.jsonl")}
    outcomes = {"worked out": 0, "refused": 0}
    for _ in range(600):
        name = rng.choice(list(texts))
        lines = texts[name].splitlines() if name.endswith("l") else [texts[name]]
        number = rng.randrange(len(lines))
        lines[number] = json.dumps(_changed(json.loads(lines[number]), rng))
        (folder / name).write_text("\n".join(lines))
        try:
            _work_out(RunData(folder))
            outcomes["worked out"] += 1
        except ConfigError:
            outcomes["refused"] += 1
        (folder / name).write_text(texts[name])
    assert min(outcomes.values()) > 50


def _work_out(run):
    assert run.series is None or run.series.poses.shape[1:] == (len(run.robots), 3)
    assert run.usage is None or len(run.usage.wall)
    assert len(run.goals) + len(run.spans) + run.end >= 0
    judge(run), merits(run.report), breach_lines(run.report)
    throughput(run), state_shares(run), station_use(run), find_bottleneck(run)


def _changed(content, rng):
    """Return a copy of JSON with one or two values replaced by odd ones, or left out."""
    content = copy.deepcopy(content)
    for _ in range(rng.choice((1, 2))):
        at, holder = content, None
        while isinstance(at, dict | list) and at and (holder is None or rng.random() < 0.7):
            key = rng.choice(list(at)) if isinstance(at, dict) else rng.randrange(len(at))
            holder, at = at, at[key]
        if holder is not None and rng.random() < 0.8:
            holder[key] = rng.choice(ODD)
        elif holder is not None:
            del holder[key]
    return content

"""Several runs side by side: differences of results, and of what they were given."""

import json

import pytest
import yaml

from swarm_report.compare import comparison, comparison_html, what_differs
from swarm_report.inputs import differences, inputs
from swarm_report.run import RunData
from tests.fakes.run_folder import make_run


def a_run(folder, **report):
    make_run(folder, robots=2, seconds=20)
    (folder / "params").mkdir()
    for number in (1, 2):
        parameters = {"robot_id": number, "traffic": {"held_length": 0.35}}
        content = {f"/Srobot{number}/navigator": {"ros__parameters": parameters}}
        (folder / "params" / f"Srobot{number}.yaml").write_text(yaml.safe_dump(content))
    content = json.loads((folder / "report.json").read_text()) | report
    (folder / "report.json").write_text(json.dumps(content))
    return RunData(folder)


def set_parameter(run, number, value):
    path = run.folder / "params" / f"Srobot{number}.yaml"
    path.write_text(path.read_text().replace("0.35", str(value)))


def row(table, name):
    return next(line for line in table if line[0] == name)


def test_results_have_differences_from_the_first_run(tmp_path):
    runs = [a_run(tmp_path / "a", makespan=200.0), a_run(tmp_path / "b", makespan=150.0)]
    found = comparison(runs)
    assert found.head == ["", "a", "b"]
    makespan = row(found.rows, "makespan")
    assert makespan == ["makespan", "200 s", "150 s (−50, −25.0 %)"]
    assert found.marks[found.rows.index(makespan), 2] == "better"
    assert row(found.rows, "goals missed")[2] == "0 (=)"


@pytest.mark.parametrize(
    ("key", "first", "second", "mark"),
    [
        ("throughput_per_minute", 3.0, 4.0, "better"),
        ("throughput_per_minute", 4.0, 3.0, "worse"),
        ("lost", {"seconds": 3.0}, {"seconds": 4.0}, "worse"),
        ("longest_stop", {"duration": 4.0}, {"duration": 3.0}, "better"),
        ("replans", 3, 4, None),  # neither good nor bad
    ],
)
def test_what_is_better(tmp_path, key, first, second, mark):
    runs = [a_run(tmp_path / "a", **{key: first}), a_run(tmp_path / "b", **{key: second})]
    assert list(comparison(runs).marks.values()) == ([mark] if mark else [])


def test_an_unknown_figure_has_no_difference(tmp_path):
    runs = [a_run(tmp_path / "a", near_misses=None), a_run(tmp_path / "b", near_misses=3)]
    assert row(comparison(runs).rows, "near misses") == ["near misses", "–", "3"]


def test_equal_inputs_and_trajectories(tmp_path):
    runs = [a_run(tmp_path / name, trajectory_sha256="f00") for name in "ab"]
    assert differences(runs)[0] == []
    assert "so are the trajectories, bit for bit" in what_differs(runs)


def test_only_the_seed(tmp_path):
    runs = [a_run(tmp_path / "a"), a_run(tmp_path / "b", seed=7)]
    assert differences(runs)[0] == [["seed", "0", "7"]]
    assert what_differs(runs).startswith("Only the seed differs: the deltas are what chance makes")


def test_parameters_of_some_robots(tmp_path):
    runs = [a_run(tmp_path / "a"), a_run(tmp_path / "b")]
    set_parameter(runs[1], 2, 0.5)
    assert differences(runs)[0] == [
        ["parameter traffic.held_length", "0.35", "0.35 (1 robots), 0.5 (1 robots)"]
    ]
    assert "parameter robot_id" not in inputs(runs[0])
    assert what_differs(runs).startswith("1 input differs.")


def test_the_page_says_both(tmp_path):
    text = comparison_html([a_run(tmp_path / "a"), a_run(tmp_path / "b", seed=7, makespan=30.0)])
    assert "Only the seed differs" in text
    assert "+50 % makespan" in text
    assert text.index("headline") < text.index("Results") < text.index("Only the seed differs")
    assert '<td class="worse">30 s (+10, +50.0 %)</td>' in text
    assert text.count("<summary>Table</summary>") == 3

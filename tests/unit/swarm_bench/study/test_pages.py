"""Pages and figures say what the lines say, with any lines."""

import re
import xml.etree.ElementTree as ET

import msgspec
import pytest

from swarm_bench.study import figures, page
from swarm_bench.study.experiments import FIRST_SEED, LOOKS
from swarm_bench.study.trials.cell import StudyRun
from tests.fakes.study import made_up, sampled, write_experiments

SEEDS = range(FIRST_SEED, FIRST_SEED + LOOKS[0])
LIGHT, DARK = "#ffffff", "#0d1117"


@pytest.fixture
def experiments(tmp_path):
    return write_experiments(tmp_path)


def values(cell, method, chance):
    if cell.has_end:
        return 100.0 * (0.8 if method == "ours" else 1.0) * chance.gauss(1.0, 0.01)
    ratio = {4: 0.8, 8: 1.2}[cell.robots] if method == "ours" else 1.0
    return 100.0 * (cell.robots / 4) * ratio * chance.gauss(1.0, 0.01)


def told(experiments, lines, settings=None):
    found = page.study_of(experiments, lines, settings or {})
    return page.markdown(found, "study", "swarm-bench study"), page.page(found), found


def test_a_study_without_lines_says_so(experiments):
    text, html, found = told(experiments, [])
    assert "No comparison with the centre (central-mapf) is decided yet." in text
    assert "Open comparisons: 6 of 6 (6 not run)." in text
    assert "from 0 lines" in text
    assert "not run" in html
    assert "No comparison with the centre (central-mapf) is decided yet." in html
    assert "1.000" not in text + html
    assert "Edition none." in html
    assert all(ET.fromstring(svg) is not None for svg in page.pictures(found).values())


def test_the_answer_counts_verdicts_and_names_the_crossover(experiments):
    text, html, _ = told(experiments, sampled(experiments, SEEDS, values))
    assert "our rules are ahead in 2, behind in 1, equal in 1; 1 undecided." in text
    assert "Neither is better everywhere: of 5 comparisons" in text
    assert re.search(r"in throughput -\d+ % \(stream 4\) to \+\d+ % \(stream 8\)", text)
    assert "they are ahead in stream with 8 robots; behind in stream with 4 robots." in text
    assert "In stream the sides change between 4 and 8 robots." in text
    assert "Of 5 expectations, right: 2, wrong: 2, open: 1." in text
    assert "- H1 **wrong**: The centre is faster." in text
    assert "Contacts: ours 0 in 80 different runs (< 3.7%)" in text
    assert "20 seeds do not decide yet" in html
    assert "central-mapf" in html


def test_stopped_runs_stay_in_the_means(experiments):
    lines = [
        msgspec.structs.replace(line, makespan=None) if line.seed % 2 else line
        for line in sampled(experiments, SEEDS, lambda *_: 100.0)
    ]
    _, html, _ = told(experiments, lines)
    row = re.search(r"<td>doorway 4</td>.*?</tr>", html[html.index("<h2>Speed") :], re.S)
    assert row is not None
    assert "200 [" in row[0]  # half at 100 s, half at 300 s
    assert ">never<" in row[0]  # the median: half of them were stopped


def test_lines_that_do_not_count_are_counted(experiments):
    lines = sampled(experiments, SEEDS, values)
    lines += [msgspec.structs.replace(line, edition="another") for line in lines[:3]]
    lines += [msgspec.structs.replace(line, settings="a=1") for line in lines[:2]]
    text, _, found = told(experiments, lines)
    assert found.edition == "made up"
    assert "3 lines of other editions of the code are left out." in text
    assert "2 lines of other cells or settings are left out." in text
    assert "from 160 lines" in text


def test_repeated_trajectories_are_counted(experiments):
    lines = sampled(experiments, SEEDS, values)
    lines[1] = msgspec.structs.replace(lines[1], trajectory_sha256=lines[0].trajectory_sha256)
    text, _, _ = told(experiments, lines)
    assert "The 160 runs have 159 different trajectories within their cells." in text


def test_contacts_and_failures_are_told(experiments):
    lines = sampled(experiments, SEEDS, values)
    lines[0] = msgspec.structs.replace(lines[0], robot_robot=2)
    lines[30] = msgspec.structs.replace(lines[30], failure="it gave up", makespan=None)
    text, html, found = told(experiments, lines)
    assert "ours 2 in 1 of 20 runs of doorway 4 (1% to 24%), 0 in 60 other different runs" in text
    centre = next(group for group in found.groups if group.method == "central-mapf")
    assert sum(bool(line.failure) for line in centre.lines) == 1
    assert "95% (76% to 99%)" in html


def test_recovery_and_loss_are_measured_against_the_twin(experiments):
    cells = {cell.name: cell for cell in experiments["speed"].cells}
    lines = [
        made_up(StudyRun("speed", cells[name], "ours", FIRST_SEED), value, done=done)
        for name, value, done in (
            ("stream 4", 100.0, [2] * 30),
            ("stream 4, 50% away 20 s", 80.0, [2] * 2 + [0] * 8 + [2] * 20),
        )
    ]
    text, html, _ = told(experiments, lines)
    assert "are back after (median, by cell): ours 50 s." in text
    tail = html[html.index("undisturbed twin") :]
    assert ">16<" in tail  # orders lost
    assert ">50 s<" in tail
    [kept] = page.study_of(experiments, lines, {}).kept
    assert kept.share.estimate == pytest.approx(0.8)


def test_what_was_tuned_is_told():
    assert page.tuned_text({}) == "No method was tuned: all have their defaults."
    told = page.tuned_text({"orca": (("orca.HORIZON", 2.0),), "ours": ()})
    assert told.endswith("ours: its defaults; orca: orca.HORIZON=2.0.")


def test_figures_are_the_same_for_the_same_lines_and_others_for_others(experiments):
    lines = sampled(experiments, SEEDS, values)
    first = page.pictures(page.study_of(experiments, lines, {}))
    assert first == page.pictures(page.study_of(experiments, list(reversed(lines)), {}))
    assert set(first) == {"throughput", "makespan", "cost", "loss"}
    changed = [
        msgspec.structs.replace(line, per_hour=line.per_hour and line.per_hour * 1.01)
        for line in lines
    ]
    second = page.pictures(page.study_of(experiments, changed, {}))
    assert second["throughput"] != first["throughput"]
    assert second["makespan"] == first["makespan"]


def luminance(color):
    channels = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    parts = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]


def contrast(color, paper):
    first, second = sorted((luminance(color), luminance(paper)))
    return (second + 0.05) / (first + 0.05)


def test_figures_can_be_read_in_light_in_dark_and_in_grey(experiments):
    for paper in (LIGHT, DARK):
        assert contrast(figures.INK, paper) > 4.0
        assert all(contrast(color, paper) > 3.0 for color, _, _ in figures.LOOKS.values())
    marks = [(mark, str(dash)) for _, mark, dash in figures.LOOKS.values()]
    assert len({mark for mark, _ in marks}) == len({dash for _, dash in marks}) == len(marks)
    lines = sampled(experiments, SEEDS, values)
    for svg in page.pictures(page.study_of(experiments, lines, {})).values():
        used = {color.lower() for color in re.findall(r"#[0-9a-fA-F]{6}\b", svg)}
        allowed = {figures.INK, *(color for color, _, _ in figures.LOOKS.values()), "#000000"}
        assert used <= allowed

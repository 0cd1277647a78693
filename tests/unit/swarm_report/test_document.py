"""The page of a run: self-contained, with a plot for each thing that is known."""

import base64
import gzip
import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import OCCUPIED, Grid
from swarm_common.model.records import Pose
from swarm_report import charts
from swarm_report.document import DRAWINGS, document_html, write_document
from swarm_report.report_command import report_app
from swarm_report.run import RunData
from tests.fakes.run_folder import make_run


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    return write_document(make_run(folder, robots=3, seconds=40, crash=True))


def test_the_page_is_whole_and_self_contained(page):
    text = page.read_text(encoding="utf-8")
    assert text.index("Failed: 5 of 6 goals reached, 1 collision") < text.index("<img")
    assert "collision of Srobot1 and Srobot2 at (1.00, 2.00)" in text
    assert not re.search(r"(src|href)=\"(?!data:|#)", text)
    for name in DRAWINGS:
        assert f'id="{name}"' in text
        assert (page.parent / "plots" / f"{name}.svg").stat().st_size > 1000
        assert (page.parent / "plots" / f"{name}.png").stat().st_size > 1000


def test_every_plot_has_its_table_and_answers_to_the_mouse(page):
    text = page.read_text(encoding="utf-8")
    for name in DRAWINGS:
        figure = text[text.index(f'id="{name}"') :].split("</figure>")[0]
        assert "<summary>Table</summary>" in figure, name
    given = re.search(r'<script type="application/json" id="charts">(.*?)</script>', text)
    charts = json.loads(given[1])
    assert set(charts["charts"]) == set(DRAWINGS)
    assert charts["map"]["source"].startswith("data:image/png")
    packed = re.search(r'id="plotly-js">(.*?)</script>', text)
    assert b"plotly.js v" in gzip.decompress(base64.b64decode(packed[1]))[:100]


def test_a_page_of_twenty_robots_is_at_most_five_megabytes(tmp_path):
    folder = make_run(tmp_path, robots=20, seconds=600)
    assert len(document_html(RunData(folder)).encode()) <= 5e6


def test_without_plotly_the_page_has_the_still_plots(tmp_path, monkeypatch):
    monkeypatch.setattr("swarm_report.page.plotly_js", lambda: "")
    text = document_html(RunData(make_run(tmp_path, robots=2, seconds=10)))
    assert text.count("<img") == len(DRAWINGS)
    assert 'id="charts"' not in text


def test_broken_robots_are_named(tmp_path):
    folder = make_run(tmp_path, robots=3, seconds=10)
    report = json.loads((folder / "report.json").read_text())
    (folder / "report.json").write_text(json.dumps(report | {"broken": ["Srobot2"]}))
    text = document_html(RunData(folder))
    assert "1 robot is broken: Srobot2" in text
    assert "Srobot2 (broken)" in text


def test_names_are_no_markup(tmp_path):
    folder = make_run(tmp_path, robots=2, seconds=10)
    sites = folder / "sites.yaml"
    sites.write_text('stations:\n  "</script><b>x": [2.0, 2.0, 0.0]\n')
    text = document_html(RunData(folder))
    assert "</script><b>x" not in text
    assert "&lt;/script&gt;&lt;b&gt;x" in text


def test_a_run_that_left_nothing_has_a_page_without_plots(tmp_path):
    folder = make_run(tmp_path, robots=3, seconds=0)
    text = write_document(folder).read_text(encoding="utf-8")
    assert "No verdict" in text
    assert "<img" not in text


def test_runs_are_compared(tmp_path):
    runs = [str(make_run(tmp_path / name, robots=2, seconds=30)) for name in ("a", "b")]
    page = tmp_path / "both.html"
    result = CliRunner().invoke(report_app, [*runs, "-o", str(page)])
    assert result.exit_code == 0, result.output
    assert "goals per minute" in page.read_text()
    assert sorted(file.stem for file in (tmp_path / "both_plots").glob("*.png")) == [
        "clearance",
        "goals",
        "merits",
    ]


def test_output_beside_one_run_is_refused(tmp_path):
    run = make_run(tmp_path / "a", robots=2, seconds=3)
    result = CliRunner().invoke(report_app, [str(run), "-o", str(tmp_path / "x.html")])
    assert isinstance(result.exception, ConfigError)
    assert "name another run" in str(result.exception)


def test_a_page_that_cannot_be_written_is_refused(tmp_path):
    runs = [str(make_run(tmp_path / name, robots=2, seconds=3)) for name in ("a", "b")]
    result = CliRunner().invoke(report_app, [*runs, "-o", "/proc/no/x.html"])
    assert isinstance(result.exception, ConfigError)


def test_names_of_stations_keep_off_walls_of_the_hall():
    """A map has a rim beyond the walls; names stood on the wall beside them."""
    cells = np.zeros((100, 200), np.int8)
    cells[:, 20:22] = OCCUPIED
    grid = Grid(cells, 0.1, 0.0, 0.0)
    places = {"loader_1": Pose(2.7, 3.0, 0.0), "unload": Pose(12.0, 5.0, 0.0)}
    assert charts._beside(SimpleNamespace(grid=grid), places) == ["middle right", "top center"]


def test_names_of_stations_at_a_wall_lie_inside_and_beside_each_other():
    grid = Grid(np.zeros((200, 400), np.int8), 0.05, 0.0, 0.0)
    places = {f"loader_{k}": Pose(0.4, 2.0 + k, 0.0) for k in range(3)}
    places["exit"] = Pose(19.7, 2.0, 0.0)
    sides = charts._beside(SimpleNamespace(grid=grid), places)
    assert sides == [*["middle right"] * 3, "middle left"]

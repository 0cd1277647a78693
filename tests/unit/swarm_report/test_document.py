"""The page of a run: self-contained, with a plot for each thing that is known."""

import re
from pathlib import Path

from typer.testing import CliRunner

from swarm_common.model.errors import ConfigError
from swarm_report.document import DRAWINGS, makespan, number, write_document
from swarm_report.report_command import report_app
from tests.fakes.run_folder import make_run


def test_the_page_is_whole_and_self_contained(tmp_path: Path) -> None:
    folder = make_run(tmp_path, robots=3, seconds=40, crash=True)
    text = write_document(folder).read_text(encoding="utf-8")
    assert text.index("Failed: 5 of 6 goals reached, 1 collision") < text.index("<img")
    assert "collision of Srobot1 and Srobot2 at (1.00, 2.00)" in text
    assert not re.search(r"(src|href)=\"(?!data:)", text)
    for name in DRAWINGS:
        assert f'id="{name}"' in text
        assert (folder / "plots" / f"{name}.svg").stat().st_size > 1000
        assert (folder / "plots" / f"{name}.png").stat().st_size > 1000


def test_a_run_that_left_nothing_has_a_page_without_plots(tmp_path: Path) -> None:
    folder = make_run(tmp_path, robots=3, seconds=0)
    text = write_document(folder).read_text(encoding="utf-8")
    assert "No verdict" in text
    assert "<img" not in text


def test_runs_are_compared(tmp_path: Path) -> None:
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


def test_numbers_are_plain() -> None:
    assert number(65948.7, "s") == "65949 s"
    assert number(0.0433, "m") == "0.0433 m"
    assert number(None) == "–"
    assert makespan({"makespan": 59.2, "goals": {"pending": 157}}) is None
    assert makespan({"makespan": 59.2, "goals": {"pending": 0}}) == 59.2


def test_a_page_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    runs = [str(make_run(tmp_path / name, robots=2, seconds=3)) for name in ("a", "b")]
    result = CliRunner().invoke(report_app, [*runs, "-o", "/proc/no/x.html"])
    assert isinstance(result.exception, ConfigError)

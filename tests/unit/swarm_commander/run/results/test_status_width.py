"""The live picture on screens of any size."""

import io

import pytest
from rich.console import Console

from swarm_commander.run.results.progress import Progress
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.results.status_table import cut, status_table

REASON = "for Srobot9, which waits for Srobot12, which stands before loader_2 since a while"


def swarm(count):
    names = [f"Srobot{number}" for number in range(1, count + 1)]
    statistics = RunStatistics.of(names, has_mission=True)
    for number, robot in enumerate(statistics.robots.values()):
        robot.active, robot.goal, robot.detail = True, "loader_2", REASON
        robot.state, robot.since = ("driving", "waiting")[number % 2], float(number)
    statistics.sim_time = 100.0
    return statistics


@pytest.mark.parametrize(("width", "height"), [(80, 24), (160, 50), (60, 16)])
@pytest.mark.parametrize("count", [5, 20, 100])
def test_the_link_stays_in_sight_and_every_robot_is_represented(width, height, count):
    file = io.StringIO()
    console = Console(file=file, width=width, height=height, force_terminal=True)
    progress = Progress(console, swarm(count), lambda: 0.0)
    progress.pin("viewer: http://127.0.0.1:8080")
    picture = progress._picture()
    assert picture[0].plain == "viewer: http://127.0.0.1:8080"
    assert len(picture) < height
    assert max(len(line.plain) for line in picture) <= width
    cells = [line.plain.split() for line in picture if line.plain.startswith("Srobot")]
    rows = sum(len(cell) > 3 and cell[3] == "s" for cell in cells)
    letters = sum(len(cell[1]) for cell in cells if set(cell[1]) <= {"d", "w"})
    assert count in (rows, letters)


def test_reasons_are_cut_between_words_at_the_true_width():
    narrow, wide = (
        status_table(swarm(2), screen_width=width)[1].plain.split("goals  ")[1]
        for width in (80, 160)
    )
    assert wide == REASON
    assert narrow.endswith("…")
    assert narrow[:-1].split() == REASON.replace(",", "").split()[: len(narrow.split())] or (
        REASON.startswith(narrow[:-1])
    )
    assert cut("before something", 8) == ""

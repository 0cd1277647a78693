"""The robots in a few lines: a letter each, one line per group, however large the swarm."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from rich.text import Text

from swarm_commander.run.results.run_statistics import RobotStatistics, RunStatistics
from swarm_common.model.palette import LOOKS, css
from swarm_common.model.robot_names import stem_and_number

LINES = 10  # at most this many groups
ALONE = 12  # lines for robots where the height of the screen is unknown
SHOWN_DETAIL = 48  # characters of what a robot says about its state
# Letter and style by state; letters repeat the colours, for people who do not see them.
MARKS = {
    **{state: (look.letter, css(look.color)) for state, look in LOOKS.items()},
    "idle": (LOOKS["idle"].letter, "dim"),
    "inactive": (LOOKS["inactive"].letter, "dim"),
    "": (LOOKS["inactive"].letter, "dim"),
    "dead": (LOOKS["dead"].letter, "bold red"),
    "gone": (" ", "dim"),
}
COUNTED = ("holding", "waiting", "recovering", "dead")


def status_table(statistics: RunStatistics, room: int = ALONE) -> list[Text]:
    """Return a line per robot, or a line per group where there is no room for that.

    Args:
        room: Lines that the screen has for it.
    """
    names = list(statistics.robots)
    if len(names) <= room:
        width = max(map(len, names), default=0)
        return [_robot_line(name, width, statistics) for name in names]
    size = -(-len(names) // LINES)
    starts = [*range(0, len(names), size), len(names)]
    groups = [names[start:end] for start, end in pairwise(starts)]
    labels = [_label(group) for group in groups]
    width = max(map(len, labels))
    lines = [
        _group_line(label.ljust(width), [statistics.robots[name] for name in group], size)
        for label, group in zip(labels, groups, strict=True)
    ]
    return [*lines, legend(statistics)]


def legend(statistics: RunStatistics) -> Text:
    """Return the meaning of the letters that are shown now.

    Args:
        statistics: Of the run; states that no robot is in are left out.
    """
    seen = {shown_state(robot) or "inactive" for robot in statistics.robots.values()}
    line = Text()
    for state, (letter, style) in MARKS.items():
        if state in seen and letter.strip():
            line.append(letter, style=style).append(f" {state}  ", style="dim")
    line.rstrip()
    return line


def shown_state(robot: RobotStatistics) -> str:
    """Return the state to show: dead and removed robots no longer report one.

    Args:
        robot: With what it said last.

    Returns:
        Empty before the first status.
    """
    if robot.left:
        return "gone"
    return "dead" if robot.died else robot.state


def _robot_line(name: str, width: int, statistics: RunStatistics) -> Text:
    """Return a robot's state, since when, goal, for whom it waits, and its goals so far."""
    robot = statistics.robots[name]
    state = shown_state(robot)
    detail = (
        robot.detail if len(robot.detail) <= SHOWN_DETAIL else f"{robot.detail[:SHOWN_DETAIL]}…"
    )
    line = Text(f"{name.ljust(width)}  ")
    line.append(f"{state or 'starting':<15}", style=_mark(state)[1])
    line.append(f"{max(0.0, statistics.sim_time - robot.since):>5.0f} s  ")
    line.append(f"{robot.goal:<12}  ")
    line.append(f"{_goals(robot.reached, robot.failed):<10}  ")
    if robot.battery is not None:
        line.append(f"{robot.battery:>4.0%}  ")
    awaited = statistics.waits.edges.get(name, "")
    if awaited and awaited not in detail:
        line.append(f"for {awaited}  ")
    return line.append(detail, style="dim")


def _group_line(label: str, robots: Sequence[RobotStatistics], width: int) -> Text:
    line = Text(f"{label}  ")
    for robot in robots:
        line.append(*_mark(shown_state(robot)))
    line.append(" " * (width - len(robots) + 2))
    reached, failed = sum(r.reached for r in robots), sum(r.failed for r in robots)
    line.append(f"{_goals(reached, failed):<10}  ")
    counts = Counter(map(shown_state, robots))
    words = [f"{counts[state]} {state}" for state in COUNTED if counts[state]]
    return line.append(", ".join(words), style="dim")


def _label(group: Sequence[str]) -> str:
    """Return `agv11-20` for robots 11 to 20, or the first and the last name."""
    if len(group) == 1:
        return group[0]
    (first_stem, _), (stem, number) = map(stem_and_number, (group[0], group[-1]))
    is_series = number and stem == first_stem
    return f"{group[0]}-{number}" if is_series else f"{group[0]}…{group[-1]}"


def _mark(state: str) -> tuple[str, str]:
    return MARKS.get(state, ("?", ""))


def _goals(reached: int, failed: int) -> str:
    word = "goal" if reached == 1 else "goals"
    return f"{reached} {word}" + (f", {failed} missed" if failed else "")

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
WIDTH = 100  # characters where the width of the screen is unknown
LEAST_DETAIL = 12  # characters below which a reason is left out
# Letter and style by state; letters repeat the colours, for people who do not see them.
MARKS = {
    **{state: (look.letter, css(look.color)) for state, look in LOOKS.items()},
    "idle": (LOOKS["idle"].letter, "dim"),
    "inactive": (LOOKS["inactive"].letter, "dim"),
    "": (LOOKS["inactive"].letter, "dim"),
    "dead": (LOOKS["dead"].letter, "bold red"),
    "broken": ("!", "dim"),
    "gone": (" ", "dim"),
}
COUNTED = ("holding", "waiting", "recovering", "dead")


def status_table(
    statistics: RunStatistics, room: int = ALONE, screen_width: int = WIDTH
) -> list[Text]:
    """Return a line per robot; without room for that, one per group and the longest stops.

    Args:
        room: Lines that the screen has for it; fewer than three are taken for three.
    """
    names = list(statistics.robots)
    if len(names) <= room:
        return _robot_lines(names, statistics, screen_width)
    lines = _group_lines(names, statistics, min(LINES, max(2, room - 1)))
    stopped = sorted(
        (name for name in names if shown_state(statistics.robots[name]) in COUNTED),
        key=lambda name: statistics.robots[name].since,
    )
    free = max(0, room - len(lines) - 1)
    lines += _robot_lines(stopped[:free], statistics, screen_width)
    lines.append(legend(statistics))
    for line in lines:
        line.truncate(screen_width, overflow="ellipsis")
    return lines


def _group_lines(names: Sequence[str], statistics: RunStatistics, count: int) -> list[Text]:
    size = -(-len(names) // count)
    starts = [*range(0, len(names), size), len(names)]
    groups = [names[start:end] for start, end in pairwise(starts)]
    labels = [_label(group) for group in groups]
    width = max(map(len, labels))
    return [
        _group_line(label.ljust(width), [statistics.robots[name] for name in group], size)
        for label, group in zip(labels, groups, strict=True)
    ]


def legend(statistics: RunStatistics) -> Text:
    """Return the meaning of the letters that are shown now.

    Args:
        statistics: Statistics of the run; states that no robot is in are left out.
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
    if robot.left or robot.is_broken:
        return "gone" if robot.left else "broken"
    return "dead" if robot.died else robot.state


def _robot_lines(names: Sequence[str], statistics: RunStatistics, width: int) -> list[Text]:
    """Return for each robot its state, since when, goal, goals so far, and for whom it waits."""
    robots = [statistics.robots[name] for name in names]
    states = [shown_state(robot) or "starting" for robot in robots]
    goals = [_goals(robot.reached, robot.failed) for robot in robots]
    name_width = max(map(len, names), default=0)
    state_width = max(map(len, states), default=0)
    goal_width = max((len(robot.goal) for robot in robots), default=0)
    goals_width = max(map(len, goals), default=0)
    lines = []
    for name, robot, state, count in zip(names, robots, states, goals, strict=True):
        line = Text(f"{name:<{name_width}}  ")
        line.append(f"{state:<{state_width}}", style=_mark(shown_state(robot))[1])
        line.append(f"{max(0.0, statistics.sim_time - robot.since):>5.0f} s  ")
        line.append(f"{robot.goal:<{goal_width}}  " if goal_width else "")
        line.append(f"{count:<{goals_width}}  ")
        if robot.battery is not None:
            line.append(f"{robot.battery:>4.0%}  ")
        awaited = statistics.waits.edges.get(name, "")
        whom = f"for {awaited}" if awaited and awaited not in robot.detail else ""
        line.append(cut(f"{whom}  {robot.detail}".strip(), width - len(line)), style="dim")
        line.truncate(width, overflow="ellipsis")
        line.rstrip()
        lines.append(line)
    return lines


def cut(text: str, width: int) -> str:
    """Return as many whole words of a text as fit, with an ellipsis if some do not.

    Args:
        width: Characters; below `LEAST_DETAIL` nothing is said.
    """
    if len(text) <= width:
        return text
    if width < LEAST_DETAIL:
        return ""
    head = text[:width].rpartition(" ")[0] or text[: width - 1]
    return f"{head.rstrip(' ,;:')}…"


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

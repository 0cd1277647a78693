"""Progress that the user sees while a run goes, and the table at its end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.results.status_table import status_table
from swarm_common.model.run_words import OPEN, makespan, robots_text

REFRESH = 0.25  # [s] of wall time between two pictures
LINE_PERIOD = 5.0  # [s] between two lines where there is no terminal
BAR = 20  # characters of the bar of a first start
SEPARATOR = " | "
STARTING = "starting"  # first word of the phases in which kernels may be compiled
SHOWN_NOTES = 8  # of a kind; the report has all


class Progress:
    """Live picture on a terminal, a line from time to time elsewhere."""

    def __init__(
        self, console: Console, statistics: RunStatistics, clock: Callable[[], float]
    ) -> None:
        """Prepare to draw.

        Args:
            clock: Wall clock [s].
        """
        self._console = console
        self._statistics = statistics
        self._clock = clock
        self._due = 0.0
        self._phase = STARTING
        self._aside = ""
        self._pinned = ""
        self._compiled: tuple[float, int] | None = None  # when first told [s], and how far it was
        self._last_line = ""
        self._shown: list[Text] = []
        self._breaches: Counter[str] = Counter()
        self._live = Live(console=console, auto_refresh=False, transient=True)

    def start(self) -> None:
        """Begin to draw."""
        if self._console.is_terminal:
            self._live.start()

    def stop(self) -> None:
        """Leave the terminal as it was."""
        self._live.stop()

    def phase(self, text: str) -> None:
        """Set the phase that is shown."""
        self._phase = text
        if not text.startswith(STARTING):
            self._aside = ""
        self._due = 0.0

    def compiling(self, ready: int, known: int) -> None:
        """Show that a first start compiles, how far it is, and an estimate of what is left."""
        if not self._phase.startswith(STARTING):
            return
        now = self._clock()
        self._compiled = self._compiled or (now, ready)
        began, first = self._compiled
        left = (known - ready) * (now - began) / (ready - first) if ready > first else None
        estimate = "" if left is None else f", about {left:.0f} s left"
        filled = BAR * ready // max(1, known)
        bar = "█" * filled + "░" * (BAR - filled) if self._console.is_terminal else ""
        self._aside = (
            f" (first start: compiling, {bar}{' ' if bar else ''}"
            f"{ready} of {known} kernels are ready{estimate})"
        )
        self._due = 0.0 if self._console.is_terminal else self._due

    def pin(self, text: str) -> None:
        """Keep a line in sight on a terminal; print it elsewhere."""
        self._pinned = text
        if not self._console.is_terminal:
            self.note(text)

    def note(self, text: str, style: str = "") -> None:
        """Print a line that stays.

        Args:
            text: Text of any length; the terminal wraps it.
            style: Style of rich, like `yellow`; empty for none.
        """
        self._console.print(Text(text, style=style), soft_wrap=True)

    def breach(self, kind: str, text: str) -> None:
        """Print a failure; after `SHOWN_NOTES` of a kind, only their number.

        Args:
            kind: In the plural, like `collisions`, for the count.
        """
        self._breaches[kind] += 1
        if self._breaches[kind] <= SHOWN_NOTES:
            self.note(text, "red")
        elif self._breaches[kind] == SHOWN_NOTES + 1 and not self._console.is_terminal:
            self.note(f"more {kind} follow; all are in the report", "red")

    def _untold(self) -> list[str]:
        return [
            f"and {count - SHOWN_NOTES} more {kind}"
            for kind, count in self._breaches.items()
            if count > SHOWN_NOTES
        ]

    def update(self) -> None:
        """Draw if it is time to."""
        now = self._clock()
        if now < self._due:
            return
        if self._console.is_terminal:
            self._due = now + REFRESH
            picture = self._picture()
            if picture != self._shown:  # no traffic to a terminal that shows it already
                self._shown = picture
                self._live.update(Group(*picture), refresh=True)
            return
        self._due = now + LINE_PERIOD
        line = summary_line(self._phase + self._aside, self._statistics)
        if line != self._last_line:
            self._console.print(Text(line), soft_wrap=True)
            self._last_line = line

    def _picture(self) -> list[Text]:
        collided = self._statistics.collisions or self._statistics.failed
        head = packed(_parts(self._phase + self._aside, self._statistics), self._console.width)
        style = "red" if collided else ""
        rest = [Text(line, style="red") for line in self._untold()]
        pinned = [Text(self._pinned, style="bold", no_wrap=True)] if self._pinned else []
        room = self._console.height - len(head) - len(rest) - len(pinned) - 1
        table = status_table(self._statistics, room, self._console.width)
        return [*pinned, *(Text(line, style=style) for line in head), *table, *rest]


def summary_line(phase: str, statistics: RunStatistics) -> str:
    """Return the state of the run in one line.

    Args:
        phase: Shown unless the world is paused.
    """
    return SEPARATOR.join(_parts(phase, statistics))


def packed(parts: Sequence[str], width: int) -> list[str]:
    """Return as few lines of at most `width` characters as hold the parts unbroken.

    Args:
        parts: At least one; one that is longer than the width has a line of its own.
    """
    lines = [parts[0]]
    for part in parts[1:]:
        longer = f"{lines[-1]}{SEPARATOR}{part}"
        if len(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines


def _parts(phase: str, statistics: RunStatistics) -> list[str]:
    goals = (
        f"{statistics.reached}/{statistics.total}" if statistics.total else str(statistics.reached)
    )
    return [
        "paused" if statistics.is_paused else phase,
        f"active {statistics.active}/{statistics.there}",
        f"goals {goals}" + (f" ({statistics.failed} missed)" if statistics.failed else ""),
        f"collisions {statistics.collisions}",
        f"holding {len(statistics.holding)}",
        f"t = {statistics.sim_time:.1f} s",
        f"{statistics.real_time_factor:.2f}x real time",
    ]


def goals_text(goals: Mapping[str, int]) -> str:
    """Return how many of all goals were reached, and what became of the others.

    Args:
        goals: Goals of the report: `sent`, `reached`, `failed`, `pending`.
    """
    reached, failed, pending = goals["reached"], goals["failed"], goals["pending"]
    under_way = min(pending, max(0, goals["sent"] - reached - failed))
    text = f"{reached} of {reached + failed + pending}, {failed} missed"
    rest = f", {pending} open: {under_way} under way, {pending - under_way} not sent"
    return text + rest if pending else text


def summary_table(report: Mapping[str, Any], code: int) -> Table:
    """Return the result of a run as a table."""
    goals, collisions = report["goals"], report["collisions"]
    cpu, memory = report["cpu_ms_per_robot_second"], report["memory_mb"]
    duration = report["goal_duration"]
    rows = {
        "goals reached": goals_text(goals),
        "collisions robot-robot, robot-world": (
            ", ".join(_with_unit(collisions[kind], "") for kind in ("robot_robot", "robot_world"))
        ),
        "near misses": _with_unit(report["near_misses"], ""),
        **_zone_rows(report.get("zones")),
        "minimum clearance": _with_unit(report["min_clearance"], "m"),
        "simulated time": _with_unit(report["sim_time"], "s"),
        "real-time factor": _with_unit(report["real_time_factor"], ""),
        "all active after": _with_unit(report["active_after_wall"], "s"),
        "makespan": OPEN if goals["pending"] else _with_unit(makespan(report), "s"),
        "goals per minute": _with_unit(report["throughput_per_minute"], ""),
        "median, longest time of a goal": f"{_with_unit(duration['median'], 's')}, "
        f"{_with_unit(duration['worst'], 's')}",
        "time lost, longest stop of a robot": _stops_text(report),
        "pushes, retreats, deadlocks resolved": (
            f"{report['pushes']}, {report['retreats']}, {report['deadlocks_resolved']}"
        ),
        "replans, recoveries": f"{report['replans']}, {report['recoveries']}",
        **_battery_rows(report["robots"]),
        "late ticks": _with_unit(report["late_ticks"], ""),
        "CPU per robot and second": (
            f"{_with_unit(cpu['total'], 'ms')} (world {_with_unit(cpu['world'], 'ms')},"
            f" navigators {_with_unit(cpu['navigators'], 'ms')},"
            f" viewer and recorder {_with_unit(cpu['onlookers'], 'ms')})"
        ),
        "memory": (
            f"world {_with_unit(memory['world'], 'MB')},"
            f" navigators {_with_unit(memory['navigators'], 'MB')}"
        ),
    }
    title = f"{robots_text(report)} in {report['world']}, seed {report['seed']}"
    table = Table(title=title, title_justify="left", show_header=False)
    for name, value in rows.items():
        table.add_row(name, value)
    table.add_row("exit code", str(code), style="bold green" if code == 0 else "bold red")
    return table


def _zone_rows(zones: Mapping[str, Any] | None) -> dict[str, str]:
    """Return what to say of keepout and speed zones; nothing in a world without any."""
    if zones is None:
        return {}
    return {
        "entries into keepout zones": f"{zones['keepout_entries']}, {zones['keepout_time']} s",
        "speeds above a limit": f"{zones['speed_violations']}, {zones['speed_violation_time']} s",
        **({"first of them": zones["first"]} if zones["first"] else {}),
    }


def _battery_rows(robots: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Return what became of the batteries; nothing where no robot has one."""
    own = {name: robot for name, robot in robots.items() if "battery_least" in robot}
    if not own:
        return {}
    empty = [name for name, robot in own.items() if robot["battery_empty_at"] is not None]
    least = min(robot["battery_least"] for robot in own.values())
    charges = sum(robot["battery_charges"] for robot in own.values())
    return {
        "lowest battery, charges": f"{least:.0%}, {charges}",
        **({"empty batteries": ", ".join(empty)} if empty else {}),
    }


def _stops_text(report: Mapping[str, Any]) -> str:
    """Return the time that robots lost, and the longest stop, as the headline has them."""
    lost, stop = report.get("lost"), report.get("longest_stop")
    if lost is None:
        return "unknown"
    return f"{lost['seconds']:.1f} s, {stop['duration'] if stop else 0.0:.1f} s"


def _with_unit(value: float | None, unit: str) -> str:
    return "unknown" if value is None else f"{value} {unit}".strip()

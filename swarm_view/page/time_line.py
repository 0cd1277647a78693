"""The time line of one page: marks of what happened, and where in time the page is."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Sequence
from typing import Any

from swarm_common.model.palette import GREEN, ORANGE, PINK, RGB, SKY, VERMILLION, css
from swarm_view.scene.views import PANEL_WIDTH
from swarm_view.scene.viser_compat import run_script
from swarm_view.state.history import History, Kind, Mark

HEIGHT = 46  # [px] of the line: signs, waits, goals, and the times below them
NARROW = 900.0  # [px] of a page on which the panel is not beside the line
PERIOD = 2.0  # [s] of wall time between two drawings of the marks
REPEAT = 1.0  # [s] of wall time after which the cursor is put again: the line may be a new one
NOW_PERIOD = 0.2  # [s] of wall time between two moves of the cursor
GROWTH = 0.01  # of the span, by which it grows before it is drawn again
MARKS_A_SECOND = 200  # that are drawn at most
MOST = 400  # marks with a sign of their own; of more only the last ones have it
SIGNS: dict[Kind, tuple[str, RGB, int]] = {  # sign, colour, [px] from above
    Kind.COLLISION: ("✖", VERMILLION, 0),
    Kind.NEAR_MISS: ("◆", ORANGE, 0),
    Kind.FAULT: ("■", PINK, 0),
    Kind.WAIT: ("▬", SKY, 16),
    Kind.GOAL: ("▮", GREEN, 26),
}
TICKS = (1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200)  # [s]
MOST_TICKS = 9
BUTTON = (
    "border:1px solid #8888;border-radius:4px;background:transparent;color:inherit;"
    "min-width:2.6em;padding:0 0.55em;margin-right:0.3em;cursor:pointer;font-size:0.8rem;"
    "line-height:1.5"
)


class TimeLine:
    """The widgets of one page, in a panel of their own."""

    def __init__(self, client: Any, *, is_live: bool) -> None:
        """Build them; a live page has a way back to the present."""
        self._client = client
        self._is_live = is_live
        self.panel = client.gui.add_panel()
        with self.panel.add_tab("Time line"):
            self._strip = client.gui.add_html("")
        self._drawn: tuple[int, float, float] = (-1, 0.0, 0.0)
        self._due = self._now_due = self._repeat_due = 0.0
        self._told: tuple[float, bool, bool] | None = None

    def place(self, width: float) -> None:
        """Lie at the lower edge of a page of a width [px], beside its panel."""
        room = width - PANEL_WIDTH - 30.0 if width > NARROW else width - 30.0
        self.panel.float(x=15, y=-15, width=max(300.0, min(1500.0, room)))

    def update(
        self, history: History, now: float, time: float, *, is_playing: bool, is_past: bool
    ) -> None:
        """Show the history, and the cursor at the page's `time` [s]; `now` is wall time.

        `is_past` tells that the page does not show the present of a live swarm.
        """
        start, end = history.span
        revision, known_start, known_end = self._drawn
        has_grown = end - known_end > GROWTH * max(10.0, end - start) or start != known_start
        if now >= self._due and (revision != history.revision or has_grown):
            self._due = now + PERIOD + len(history.marks) / MARKS_A_SECOND
            self._drawn = history.revision, start, end
            self._strip.content = strip_html(
                history.marks, start, end, time, is_live=self._is_live, gaps=history.gaps
            )
            self._told = None
        shown = round(time, 1), is_playing, is_past
        if now >= self._repeat_due or (now >= self._now_due and shown != self._told):
            self._now_due, self._repeat_due = now + NOW_PERIOD, now + REPEAT
            self._told = shown
            flags = f"{str(is_playing).lower()}, {str(is_past).lower()}"
            run_script(self._client, f"window.swarm.showTime({time:.2f}, {flags})")


def strip_html(
    marks: Sequence[Mark], start: float, end: float, now: float, *, is_live: bool,
    gaps: Sequence[tuple[float, float]] = (),
) -> str:  # fmt: skip
    """Return the time line from `start` to `end` [s], with the cursor at `now` [s].

    Of `gaps` (from, to) [s] nothing is known.
    """
    length = max(1.0, end - start)
    counts = Counter(mark.kind for mark in marks)
    legend = " &nbsp; ".join(
        f"<span style='white-space:nowrap;opacity:{1.0 if counts[kind] else 0.85}'>"
        f"<span style='color:{css(color)}'>{sign}</span> {kind.value} {counts[kind]}</span>"
        for kind, (sign, color, _) in SIGNS.items()
    )
    buttons = "".join(
        f"<button style='{BUTTON}' title='{title}' data-swarm-send='{kind}'"
        f" data-swarm-value='{value}'>{label}</button>"
        for label, kind, value, title in _buttons(marks, is_live=is_live)
    )
    goals = [mark for mark in marks if mark.kind is Kind.GOAL]
    others = [mark for mark in marks if mark.kind is not Kind.GOAL]
    path = "".join(f"M{1000 * (mark.time - start) / length:.1f} 26v8" for mark in goals)
    svg = (
        f"<svg viewBox='0 0 1000 {HEIGHT}' preserveAspectRatio='none' width='100%'"
        f" height='{HEIGHT}' style='position:absolute;left:0;top:0'>"
        f"<path d='{path}' stroke='{css(GREEN)}' stroke-width='2'"
        f" vector-effect='non-scaling-stroke'/></svg>"
    )
    signs = "".join(_sign(mark, start, length) for mark in others[-MOST:])
    hatches = "".join(_hatch(gap, start, length) for gap in gaps)
    share = min(1.0, max(0.0, (now - start) / length))
    cursor = (
        f"<div data-swarm-now style='position:absolute;top:0;bottom:0;width:2px;"
        f"left:{100.0 * share:.2f}%;background:currentColor;pointer-events:none'></div>"
    )
    line = (
        f"<div data-swarm-line data-start='{start:.2f}' data-end='{start + length:.2f}'"
        f" style='position:relative;height:{HEIGHT}px;cursor:pointer;background:#8882;"
        f"border-radius:4px;overflow:hidden'>{_ticks(start, length)}{hatches}{svg}{signs}"
        f"{cursor}</div>"
    )
    return (
        f"<div style='padding:0.2em 0.8em 0.5em;font-size:0.8rem'>"
        f"<div style='margin-bottom:0.3em;display:flex;flex-wrap:wrap;gap:0.2em 1em'>"
        f"<span>{buttons}<b data-swarm-clock>{now:.1f} s</b></span><span>{legend}</span></div>"
        f"{line}</div>"
    )


def _buttons(marks: Sequence[Mark], *, is_live: bool) -> list[tuple[str, str, str, str]]:
    rows = [
        ("|◂", "mark", "-1", "To the mark before (goals left out)"),
        ("−1 s", "step", "-10", "A second back"),
        ("◂", "step", "-1", "A tick of 0.1 s back"),
        ("❚❚", "play", "0", "Play or pause what is shown here"),
        ("▸", "step", "1", "A tick of 0.1 s on"),
        ("+1 s", "step", "10", "A second on"),
        ("▸|", "mark", "1", "To the next mark (goals left out)"),
    ]
    return [*rows, ("Live", "live", "0", "Back to the present")] if is_live else rows


def _sign(mark: Mark, start: float, length: float) -> str:
    sign, color, top = SIGNS[mark.kind]
    left = 100.0 * (mark.time - start) / length
    send = f"data-swarm-send='seek' data-swarm-value='{mark.time:.1f}'"
    title = html.escape(f"{mark.time:.1f} s: {mark.text}", quote=True)
    if mark.kind is Kind.WAIT:
        wide = 100.0 * (mark.end - mark.time) / length
        style = (
            f"left:{left:.2f}%;width:{wide:.2f}%;min-width:3px;top:{top}px;height:8px;"
            f"background:{css(color)};opacity:0.75;border-radius:2px"
        )
        return f"<span {send} title='{title}' style='position:absolute;{style}'></span>"
    style = f"left:calc({left:.2f}% - 0.4em);top:{top}px;color:{css(color)};line-height:16px"
    return f"<span {send} title='{title}' style='position:absolute;{style}'>{sign}</span>"


def _hatch(gap: tuple[float, float], start: float, length: float) -> str:
    left, wide = 100.0 * (gap[0] - start) / length, 100.0 * (gap[1] - gap[0]) / length
    return (
        f"<span title='{gap[0]:.1f} s to {gap[1]:.1f} s: not known, no page was open'"
        f" style='position:absolute;top:0;bottom:0;left:{left:.2f}%;width:{wide:.2f}%;"
        f"background:repeating-linear-gradient(135deg,#8888 0 2px,transparent 2px 7px)'></span>"
    )


def _ticks(start: float, length: float) -> str:
    step = next((tick for tick in TICKS if length / tick <= MOST_TICKS), TICKS[-1])
    first = int(-(-start // step)) * step
    return "".join(
        f"<span style='position:absolute;left:{100.0 * (time - start) / length:.2f}%;bottom:0;"
        f"top:0;border-left:1px solid #8884;padding:0 0 2px 3px;font-size:0.7rem;opacity:0.85;"
        f"display:flex;align-items:end;line-height:1'>{time:g}</span>"
        for time in range(first, int(start + length) + 1, step)
    )


def next_mark(marks: Sequence[Mark], time: float, direction: int) -> Mark | None:
    """Return the nearest mark, of those that are no goals, after a time [s] or before it."""
    found = [mark for mark in marks if mark.kind is not Kind.GOAL]
    if direction > 0:
        return min((m for m in found if m.time > time + 0.05), key=lambda m: m.time, default=None)
    return max((m for m in found if m.time < time - 0.05), key=lambda m: m.time, default=None)

"""Text of the panel, as Markdown and HTML."""

from __future__ import annotations

import html
import math
from collections import Counter
from collections.abc import Mapping, Sequence

from swarm_common.middleware.topic_table import ROBOT_TOPICS
from swarm_common.model.palette import LOOKS, RGB, VERMILLION, css, state_color
from swarm_common.model.records import FloatArray
from swarm_common.model.run_words import waits_for
from swarm_view.state.decode import ReportedState
from swarm_view.state.history import StateChange
from swarm_view.state.swarm import Swarm

LINK = "#3b8eea"  # seen on light and dark ground
STYLE = "font-size:0.8em;line-height:1.5;padding:0.2em 0.8em"


def figures(swarm: Swarm, paused: bool | None, cpu: str) -> list[tuple[str, str]]:
    """Return the live verdict: time, goals, collisions, clearance, throughput."""
    verdict, states = swarm.verdict, swarm.states
    reached = sum(state.goals_reached for state in states.values())
    failed = sum(state.goals_failed for state in states.values())
    rows = [("simulated time", f"{swarm.time:.1f} s{' (paused)' if paused else ''}")]
    if verdict is not None:
        rows.append(("real-time factor", f"{verdict.real_time_factor:.2f}"))
        rows.append(("robots", f"{verdict.robots}, {verdict.answering} answering"))
    rows.append(("goals", f"{reached} reached, {failed} tries failed"))
    if swarm.time > 0.0:
        rows.append(("goals per minute", f"{60.0 * reached / swarm.time:.1f}"))
    if verdict is not None:
        robots, world = verdict.collisions_robot_robot, verdict.collisions_robot_world
        gap = verdict.min_clearance
        rows.append(("collisions", f"{robots} robot-robot, {world} robot-world"))
        clearance = f"{gap:.3f} m" if math.isfinite(gap) else "none near"
        rows.append(("smallest clearance", clearance))
        rows.append(("late answers", str(verdict.late_ticks)))
    if cpu:
        rows.append(("CPU", cpu))
    return rows


def verdict_html(swarm: Swarm, paused: bool | None, cpu: str) -> str:
    """Return the live verdict and the legend; collisions stand out."""
    verdict, rows = swarm.verdict, figures(swarm, paused, cpu)
    if verdict is not None and verdict.collisions_robot_robot + verdict.collisions_robot_world:
        bold = f"<b style='color:{css(VERMILLION)}'>"
        rows = [
            (name, f"{bold}{text}</b>" if name == "collisions" else text) for name, text in rows
        ]
    return _table(rows) + _legend(swarm.states)


def counted_legend(states: Mapping[str, ReportedState]) -> list[tuple[str, str]]:
    """Return the states that robots are in with their numbers, and their colours."""
    counts = Counter(state.state for state in states.values())
    return [
        (f"{name} {counts[name]}", css(look.color)) for name, look in LOOKS.items() if counts[name]
    ]


def _table(rows: Sequence[tuple[str, str]]) -> str:
    cells = "".join(
        f"<tr><td style='opacity:0.85;padding-right:0.8em'>{name}</td><td>{value}</td></tr>"
        for name, value in rows
    )
    return f"<div style='{STYLE}'><table>{cells}</table></div>"


def _legend(states: Mapping[str, ReportedState]) -> str:
    """Return each colour and how many robots have it, in few lines; a hint says what it means."""
    counts = Counter(state.state for state in states.values())
    signs = " ".join(
        f"<span title='{html.escape(look.meaning, quote=True)}' style='display:inline-block;"
        f"min-width:7.5em;opacity:{1.0 if counts[name] else 0.85}'>{dot(look.color)} {name}"
        f" {counts[name]}</span>"
        for name, look in LOOKS.items()
    )
    return f"<div style='{STYLE}'>{signs}</div>"


def dot(color: RGB) -> str:
    """Return a dot in a colour, seen on light and dark ground."""
    size = "display:inline-block;width:0.75em;height:0.75em;border-radius:50%"
    return f"<span style='{size};background:{css(color)};border:1px solid #888'></span>"


def robot_html(
    robot: str, states: Mapping[str, ReportedState], url: str, true_pose: FloatArray | None = None,
    since: float | None = None, now: float = 0.0, saw_begin: bool = True, *, is_past: bool = False,
) -> str:  # fmt: skip
    """Return the state of one robot, why it waits and for whom, and a link to its own page.

    Args:
        true_pose: (3,) in map; None if unknown.
        since: [s] when it entered its state; None if unknown.
        now: [s] of simulated time.
        saw_begin: Whether it entered its state at `since`; else earlier.
        is_past: Whether the pose is the true one, and the times are later ones.
    """
    name, state = html.escape(robot), states.get(robot)
    link = f"<a href='{html.escape(url)}' target='_blank' style='color:{LINK}'>page of its own</a>"
    if state is None:
        return _table([(name, f"has said nothing yet; {link}")])
    look = LOOKS.get(state.state)
    words = " for" if saw_begin else " for at least"
    lasting = "" if since is None else f"{words} {max(0.0, now - since):.0f} s"
    rows = [
        (name, link),
        ("state", f"{dot(state_color(state.state))} {html.escape(state.state)}{lasting}"),
        ("why", html.escape(state.detail) or (look.meaning if look else "&nbsp;")),
    ]
    chain = wait_chain(robot, states)
    if chain:
        rows.append(("waits for", " &rarr; ".join(_robot_link(other, states) for other in chain)))
    pose, off = state.pose_map, ""
    if true_pose is not None:
        off = f", {math.hypot(pose.x - true_pose[0], pose.y - true_pose[1]):.2f} m off"
    rows.append(
        ("place" if is_past else "estimate", f"({pose.x:.2f}, {pose.y:.2f}, {pose.yaw:.2f}){off}")
    )
    if state.goal_map is not None:
        goal = state.goal_map
        is_known = math.isfinite(state.distance_remaining)
        far = f", {state.distance_remaining:.1f} m to go" if is_known else ""
        rows.append(("goal", f"({goal.x:.2f}, {goal.y:.2f}){far}"))
    if state.station:
        place = f", number {state.queue_place} in the queue" if state.queue_place else ""
        rows.append(("station", f"{html.escape(state.station)}{place}"))
    if math.isfinite(state.battery):
        rows.append(("battery", f"{state.battery:.0%}"))
    rows.append(("goals", f"{state.goals_reached} reached, {state.goals_failed} tries failed"))
    if not is_past:
        rows.append(("waited, held", f"{state.wait_time:.0f} s, {state.hold_time:.0f} s"))
    return _table(rows)


def wait_chain(robot: str, states: Mapping[str, ReportedState]) -> list[str]:
    """Return the chain of robots that wait for each other from this one on; a circle once round."""
    chain: list[str] = []
    while robot in states and len(chain) == len(set(chain)):
        robot = waits_for(states[robot].state, states[robot].detail)
        if not robot:
            break
        chain.append(robot)
    return chain


def _robot_link(robot: str, states: Mapping[str, ReportedState]) -> str:
    """Return a robot's name, which selects it when clicked, and what it does."""
    name = html.escape(robot)
    what = f" ({html.escape(states[robot].state)})" if robot in states else ""
    style = f"color:{LINK};cursor:pointer;text-decoration:underline"
    send = f"data-swarm-send='select' data-swarm-text='{name}'"
    return f"<span style='{style}' {send}>{name}</span>{what}"


def history_html(changes: Sequence[StateChange], now: float) -> str:
    """Return what a robot did lately, the newest first; a click on a time goes there."""
    rows, end = [], now
    for change in changes:
        state = change.state
        time = (
            f"<span style='color:{LINK};cursor:pointer' data-swarm-send='seek'"
            f" data-swarm-value='{change.time:.1f}'>{change.time:.1f} s</span>"
        )
        where = f" {html.escape(state.station)}" if state.station else ""
        what = f"{dot(state_color(state.state))} {html.escape(state.state)}{where}"
        rows.append((time, f"{what}, {end - change.time:.0f} s"))
        end = change.time
    return _table(rows or [("nothing yet", "")])


def topics_html(robot: str) -> str:
    """Return the topics of a robot, each with a button that copies its name."""
    rows = []
    for topic in ROBOT_TOPICS:
        name = html.escape(f"/{robot}/{topic.name}", quote=True)
        button = (
            f"<span data-swarm-copy='{name}' title='Copy the name of this {topic.type}'"
            f" style='cursor:pointer;color:{LINK}'>copy</span>"
        )
        rows.append(f"<tr><td style='padding-right:0.6em'>{button}</td><td>{name}</td></tr>")
    return f"<div style='{STYLE};word-break:break-all'><table>{''.join(rows)}</table></div>"


def stations_html(states: Mapping[str, ReportedState]) -> str:
    """Return the robot that holds each station, and the queue of robots that wait for it."""
    queues: dict[str, list[tuple[int, str]]] = {}
    for robot, state in states.items():
        if state.station:
            queues.setdefault(state.station, []).append((state.queue_place, robot))
    rows = []
    for station, queue in sorted(queues.items()):
        holders = ", ".join(robot for place, robot in sorted(queue) if place == 0) or "free"
        waiting = ", ".join(robot for place, robot in sorted(queue) if place > 0)
        rows.append((html.escape(station), f"{holders} &larr; {waiting}" if waiting else holders))
    return _table(rows or [("no station is held or wanted", "")])


def is_driving(state: ReportedState | None) -> bool:
    """Return whether a robot is in no need of attention."""
    return state is None or state.state in ("driving", "pausing", "charging", "idle")

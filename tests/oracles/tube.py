"""Slow twin of the reservation rules G1..G5, one neighbour and one point at a time."""

import math
from dataclasses import dataclass, field

Point = tuple[float, float]
HEARING = 5.58  # [m] within which a request has to be acknowledged


@dataclass
class Other:
    """What is known of one neighbour."""

    id: int
    age: int
    is_gone: bool
    priority: int
    radius: float
    blocked: int
    held: list[Point]
    wanted: list[Point] = field(default_factory=list)
    intent: list[Point] = field(default_factory=list)
    acknowledged: int = 99  # last point of ours whose request it has acknowledged


@dataclass
class Own:
    """What a robot knows of itself."""

    id: int
    radius: float
    priority: int
    yields_for: int
    published: list[Point]
    push_ticks: int = 3
    slack: float = 0.02


def gap(point: Point, others: list[Point]) -> float:
    """Return the distance to the nearest of some points, inf without any."""
    return min((math.dist(point, other) for other in others), default=math.inf)


def comes_near(
    point: Point,
    before: Point,
    claimed: list[Point],
    reach: float,
    slack: float,
    rounding: float = 1e-6,
) -> bool:
    """Return whether a point is too near to any claimed one from which it does not lead away.

    rounding: of squared distances [m²], by which a step away may fail.
    """
    return any(
        math.dist(point, one) < reach - slack
        and math.dist(point, one) ** 2 < math.dist(before, one) ** 2 - rounding
        for one in claimed
    )


def refusal(own: Own, other: Other, point: Point, before: Point, origin: Point) -> str:
    """Return the rule by which a neighbour denies a point, '' if it does not."""
    reach = own.radius + other.radius
    slack = own.slack if own.yields_for else 0.0
    if comes_near(point, before, other.held, reach, slack):
        return "G2 held"
    if other.is_gone:
        return "G2 wanted" if comes_near(point, before, other.wanted, reach, 0.0) else ""
    wins = (own.priority, -own.id) > (other.priority, -other.id)
    wanted: list[Point] = []
    end = other.held[-1]
    for candidate in other.wanted:
        if comes_near(candidate, end, own.published, reach, own.slack, 1e-5):
            break  # it cannot be granted to the neighbour while we hold that place
        wanted.append(candidate)
        end = candidate
    if not wins and gap(point, wanted) < reach - slack:
        return "G2 wanted"
    ahead = other.intent[:8]
    is_entitled = other.blocked >= own.push_ticks and not wins
    is_exempt = own.yields_for or gap(origin, ahead) < reach
    if is_entitled and not is_exempt and gap(point, ahead) < reach:
        return "G5"
    return ""


def extend(
    path: list[Point],
    stop: int,
    last: int,
    confirmed: int,
    own: Own,
    others: list[Other],
    obstacles: list[Point],
    clearance: float,
) -> tuple[int, str]:
    """Return (new stop, rule that ended the growth, '' if all of it was granted)."""
    for k in range(stop + 1, last + 1):
        here, there = gap(path[k], obstacles), gap(path[k - 1], obstacles)
        if here < clearance and here <= there:
            return k - 1, "obstacle"
        waits = k > confirmed
        for other in others:
            rule = refusal(own, other, path[k], path[k - 1], path[stop])
            if rule:
                return k - 1, rule
            is_near = math.dist(path[stop], other.held[0]) < HEARING
            if is_near and k > other.acknowledged and not other.is_gone:
                waits = True
        if waits:
            return k - 1, "G1 or G3"
    return last, ""

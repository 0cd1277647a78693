"""Whether stations and robots can serve the orders at all: what is certain before a run."""

from __future__ import annotations

import dataclasses
import math
from collections import defaultdict
from collections.abc import Callable, Sequence

import numpy as np

from swarm_common.model.errors import ConfigError
from swarm_common.model.grid import Grid
from swarm_common.model.records import RobotSpec
from swarm_common.model.sites import Sites
from swarm_mission.orders.order import OrderPlan
from swarm_mission.orders.way_lengths import WayLengths

HOUR = 3600.0  # [s]
MOST_ROBOTS = 200  # of any swarm
Way = Callable[[str, str], float]  # [m] from a station to another


def measured_demand(
    plan: OrderPlan, sites: Sites, grid: Grid | None, specs: Sequence[RobotSpec], robots: int
) -> tuple[WayLengths, list[str]]:
    """Return the ways to all stations of the orders for the slimmest robot, and `check_demand`.

    Args:
        grid: Upright map; None where it is not known.
        robots: Number of robots that take orders.

    Raises:
        ConfigError: If no swarm can serve the orders.
    """
    stations = {name: sites.stations[name] for name in plan.stations}
    ways = WayLengths(stations, grid, min(spec.inscribed_radius for spec in specs))
    fastest = max(spec.max_vel_x for spec in specs)
    return ways, check_demand(plan, ways.between, fastest, robots)


def check_demand(plan: OrderPlan, way: Way, speed: float, robots: int) -> list[str]:
    """Refuse orders that no swarm can serve.

    Args:
        way: Shortest way between two stations; inf if there is none.
        speed: [m/s] of the fastest robot.

    Returns:
        What may end badly, a sentence each.

    Raises:
        ConfigError: If a station gets more than it can serve, whatever the robots do, or there is
            no way between two stations.
    """
    for stream in plan.streams:
        for origin, target, _ in stream.routes():
            if math.isinf(way(origin, target)):
                raise ConfigError(
                    f"orders, stream {stream.number}: the map has no way from {origin} to {target}"
                )
    endless = [stream for stream in plan.streams if not stream.arrivals.is_finite]
    for station, (rate, busy) in _station_load(plan).items():
        if busy >= 1.0 and endless:
            raise ConfigError(
                f"orders: {station} gets {rate:.0f} orders/h and needs {busy * HOUR / rate:.3g} s"
                f" for each: it would be busy for {100.0 * busy:.0f} % of the time, and no swarm"
                " can serve that; lower the rate or the service time, or add stations"
            )
    rate = sum(stream.arrivals.peak_rate for stream in plan.streams)
    needed = math.ceil(least_robots(plan, way, speed) - 1e-6)
    if needed <= robots:
        return []
    said = f"{rate:.0f} orders/h need at least {needed} robots by distance alone"
    lasting = dataclasses.replace(plan, streams=tuple(endless)) if endless else None
    if lasting is not None and least_robots(lasting, way, speed) > MOST_ROBOTS:  # not by a burst
        raise ConfigError(f"orders: {said}, and a swarm has up to {MOST_ROBOTS}; lower the rate")
    return [f"{said}; there are {robots}"]


def least_robots(plan: OrderPlan, way: Way, speed: float) -> float:
    """Return how many robots the orders keep busy at least.

    Each drives from origin to target with goods, and from targets back to origins without; the
    empty ways are the shortest that balance what comes and goes (a transport problem), and the
    service times are added. Robots that carry several orders at a time share all of it.
    """
    loaded, served = 0.0, 0.0
    surplus: defaultdict[str, float] = defaultdict(float)  # robots/h that come with goods and go on
    for stream in plan.streams:
        rate = stream.arrivals.peak_rate
        served += rate * (stream.loading.mean + stream.unloading.mean)
        for origin, target, share in stream.routes():
            loaded += rate * share * way(origin, target)
            surplus[target] += rate * share
            surplus[origin] -= rate * share
    way_per_hour = loaded + _empty_way(surplus, way)
    return (way_per_hour / speed + served) / HOUR / plan.capacity


def _empty_way(surplus: dict[str, float], way: Way) -> float:
    """Return the shortest way [m/h] on which empty robots go from where they are to be loaded."""
    from scipy.optimize import linprog

    givers = [name for name, flow in surplus.items() if flow > 1e-9]
    takers = [name for name, flow in surplus.items() if flow < -1e-9]
    if not givers:
        return 0.0
    costs = [way(giver, taker) for giver in givers for taker in takers]
    rows, flows = [], []
    for index, giver in enumerate(givers):
        row = np.zeros((len(givers), len(takers)))
        row[index, :] = 1.0
        rows.append(row.ravel())
        flows.append(surplus[giver])
    for index, taker in enumerate(takers):
        row = np.zeros((len(givers), len(takers)))
        row[:, index] = 1.0
        rows.append(row.ravel())
        flows.append(-surplus[taker])
    finite = np.nan_to_num(np.array(costs), posinf=1e6)
    return float(linprog(finite, A_eq=np.array(rows), b_eq=flows).fun)


def _station_load(plan: OrderPlan) -> dict[str, tuple[float, float]]:
    """Return the orders per hour of each station, and the share of its time that they take."""
    rates: defaultdict[str, float] = defaultdict(float)
    seconds: defaultdict[str, float] = defaultdict(float)
    for stream in plan.streams:
        if stream.arrivals.is_finite:
            continue
        rate = stream.arrivals.peak_rate
        for origin, target, share in stream.routes():
            for name, service in ((origin, stream.loading), (target, stream.unloading)):
                rates[name] += rate * share
                seconds[name] += rate * share * service.mean
    return {name: (rates[name], seconds[name] / HOUR) for name in sorted(rates)}

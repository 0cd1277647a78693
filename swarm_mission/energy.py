"""Whether batteries can be enough for a mission: what is certain before a run begins."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

from swarm_common.model.battery import BatterySpec
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import CONTROL_PERIOD, RobotSpec
from swarm_common.model.sites import Sites
from swarm_mission.leg import Stop

CURE = "name stations that charge, like `charging: [charger_1]`"


def check_energy(
    robots: Mapping[str, RobotSpec], stops: Mapping[str, Sequence[Stop]], sites: Sites, where: str
) -> list[str]:
    """Refuse goals that no robot can reach on one charge where nothing charges it.

    Args:
        robots: Model of each robot by name; those without a battery do not count.
        stops: Goals of each robot in order, by name; where a pose is not known yet, it is NaN.

    Returns:
        What may end badly, a sentence each.

    Raises:
        ConfigError: If a robot's goals take more than its battery holds and there is no charging
            station.
    """
    batteries = {name: spec.battery for name, spec in robots.items() if spec.battery is not None}
    if not batteries:
        return []
    if sites.charging:
        return _too_few_stations(list(batteries.values()), len(sites.charging))
    for name, battery in batteries.items():
        needed = least_energy(battery, robots[name].max_vel_x, stops.get(name, ()))
        held = battery.capacity * battery.initial[1]
        if needed > held:
            raise ConfigError(
                f"{where}: {name} needs {needed:.3g} Wh or more for its goals, its battery holds"
                f" {held:.3g} Wh and no station charges it; {CURE}, or give it less to do"
            )
    first = min(batteries, key=lambda name: _lasting(batteries[name]))
    return [
        f"no station in {where} charges robots: {first} stands still after"
        f" {_lasting(batteries[first]) / 60.0:.0f} min at the latest; {CURE}"
    ]


def least_energy(battery: BatterySpec, speed: float, stops: Sequence[Stop]) -> float:
    """Return the energy [Wh] that goals take at least: straight ways at full speed, and pauses.

    Args:
        speed: [m/s] at most.
    """
    ways = [a.pose_map.distance(b.pose_map) for a, b in itertools.pairwise(stops)]
    way = sum(length for length in ways if math.isfinite(length))
    pauses = sum(stop.pause_ticks for stop in stops) * CONTROL_PERIOD * battery.idle_power
    return battery.capacity * battery.share_of_way(way, speed) + pauses / 3600.0


def _lasting(battery: BatterySpec) -> float:
    """Return how long [s] a robot can stand on one charge; inf if that takes nothing."""
    energy = battery.joules * battery.initial[1]
    return energy / battery.idle_power if battery.idle_power else math.inf


def _too_few_stations(batteries: Sequence[BatterySpec], stations: int) -> list[str]:
    """Say if the robots draw more at rest than the stations put into them."""
    drawn = sum(battery.idle_power for battery in batteries)
    given = stations * max(battery.charge_power for battery in batteries)
    if drawn < given:
        return []
    return [
        f"{len(batteries)} robots draw {drawn:.3g} W at rest and {stations} charging stations give"
        f" {given:.3g} W: robots will stand still with an empty battery; more stations, or a"
        " higher charge_power"
    ]

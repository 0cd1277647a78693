"""A centre in the bench: robots report to it in each tick, and take its orders."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from swarm_bench.runs.methods import Driver
from swarm_central.link import Centre
from swarm_nav.interfaces import Led


class Commanded(Driver, Led, Protocol):
    """A driver that reports to a centre and takes its orders."""


def exchange(centre: Centre, tick: int, drivers: Sequence[Commanded], dead: set[int]) -> None:
    """Let robots and centre speak in a tick in which the robots have decided.

    Args:
        dead: Indices of those that neither report nor hear.
    """
    reports = [driver.report() for index, driver in enumerate(drivers) if index not in dead]
    for order in centre.step(tick, [each for each in reports if each is not None]):
        if order.robot_id - 1 not in dead:
            drivers[order.robot_id - 1].take_order(order)

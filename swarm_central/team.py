"""A method that decides for all robots: what it hears from them, and what it tells them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from swarm_common.model.central import RobotReport, TeamOrder
from swarm_common.model.grid import Grid
from swarm_common.model.records import RobotSpec
from swarm_common.model.sites import Sites
from swarm_nav.core.config import NavConfig

__all__ = ["RobotReport", "Team", "TeamFactory", "TeamOrder"]


class Team(Protocol):
    """Decides for all robots, once per control tick."""

    def observe(self, tick: int, states: Sequence[RobotReport]) -> None:
        """Receive the reports that arrived in a tick.

        Args:
            states: At most one per robot; some are lost or late.
        """

    def decide(self) -> Sequence[TeamOrder]:
        """Return the orders to send in the tick of the last `observe`."""

    def figures(self) -> Mapping[str, float]:
        """Return counters for the result of a run, by name."""


class TeamFactory(Protocol):
    """Makes the centre of a run."""

    def __call__(
        self,
        config: NavConfig,
        specs: Sequence[RobotSpec],
        grid: Grid,
        sites: Sites,
        central: Mapping[str, Any],
    ) -> Team:
        """Return a centre that knows the robots' models and the map, but not where they are.

        Args:
            config: Configuration of the robots.
            specs: Models of the robots.
            grid: The map.
            sites: Sites of the world.
            central: Parameters of the centre, by name.
        """

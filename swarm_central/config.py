"""Parameters of the centre."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from swarm_common.files.convert import convert
from swarm_common.model.errors import ConfigError
from swarm_common.model.schema import Count, NotNegative, check_fields

Planner = Literal["pibt", "lacam"]
ReleasedShare = Annotated[float, Meta(ge=0.0, le=1.0)]
SolverTime = Annotated[float, Meta(gt=0.0, le=600.0)]


@dataclass(frozen=True, slots=True, kw_only=True)
class CentralConfig:
    """Parameters of the centre: how it plans, and how near robots may come."""

    margin: NotNegative = 0.01  # [m] that each robot keeps beyond its circumscribed radius
    wall_margin: NotNegative = 0.04  # [m] likewise towards walls
    gap: NotNegative = 0.06  # [m] between the circles of robots on neighbouring vertices
    lookahead: NotNegative = 0.15  # [m] that a robot is given ahead of its last report
    stop_time: NotNegative = 0.4  # [s] that braking and starting around a turn take
    period: Count = 5  # ticks between two plans
    least_period: Count = 2  # ticks, likewise where a goal has changed
    horizon: Count = 6  # steps that are planned ahead
    planner: Planner = "pibt"  # pibt; lacam: with pibt where it finds no plan in time
    expansions: Count = 400  # of LaCAM* for one plan
    solver: str = ""  # path of an external solver in place of both; empty for none
    solver_time: SolverTime = 1.0  # [s] of wall time for a plan; it is killed 10 s after that
    patience: int = 30  # ticks after which a robot that is not heard counts as standing for ever
    # Robots that go for their goals at once, by the roadmap's vertices; the others make way.
    released_share: ReleasedShare = 0.06
    most_queued: Count = 10  # of these, at most, go for the same place
    most_age: float = 240.0  # [s] after which a goal counts before all nearer ones

    def __post_init__(self) -> None:
        check_fields(self, "central")
        if self.solver and self.planner != "pibt":
            raise ConfigError(
                f"central.planner is {self.planner} and central.solver is {self.solver}; only one "
                "of them can plan: leave the other out"
            )

    def spacing(self, radius: float) -> float:
        """Return the distance [m] between neighbouring vertices.

        Args:
            radius: [m] of the largest robot.
        """
        return 2.0 * radius + self.gap


def central_from_texts(texts: Mapping[str, str]) -> CentralConfig:
    """Return parameters given as texts.

    Raises:
        ConfigError: If one is unknown or no value of its type.
    """
    return convert(dict(texts), CentralConfig, "central", strict=False)

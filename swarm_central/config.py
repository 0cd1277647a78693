"""Parameters of the centre."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import msgspec

from swarm_common.files.yaml_io import check_keys
from swarm_common.model.errors import ConfigError, UnknownNameError

PLANNERS = ("pibt", "lacam")
MOST_SOLVER_TIME = 600.0  # [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class CentralConfig:
    """Parameters of the centre: how it plans, and how near robots may come."""

    margin: float = 0.01  # [m] that each robot keeps beyond its circumscribed radius
    wall_margin: float = 0.04  # [m] likewise towards walls
    gap: float = 0.06  # [m] between the circles of robots on neighbouring vertices
    lookahead: float = 0.15  # [m] that a robot is given ahead of its last report
    stop_time: float = 0.4  # [s] that braking and starting around a turn take
    period: int = 5  # ticks between two plans
    least_period: int = 2  # ticks, likewise where a goal has changed
    horizon: int = 6  # steps that are planned ahead
    planner: str = "pibt"  # pibt; lacam: with pibt where it finds no plan in time
    expansions: int = 400  # of LaCAM* for one plan
    solver: str = ""  # path of an external solver in place of both; empty for none
    solver_time: float = 1.0  # [s] of wall time that it gets for a plan; killed 10 s after that
    patience: int = 30  # ticks after which a robot that is not heard counts as standing for ever
    most_released: int = 45  # robots that go for their goals at once; the others make way
    most_queued: int = 10  # of these, at most, go for the same place
    most_age: float = 240.0  # [s] after which a goal counts before all nearer ones

    def __post_init__(self) -> None:
        for name in ("margin", "wall_margin", "gap", "lookahead", "stop_time"):
            if getattr(self, name) < 0.0:
                raise ConfigError(
                    f"central.{name} is {getattr(self, name)}; it must not be negative"
                )
        if self.solver and self.planner != "pibt":
            raise ConfigError(
                f"central.planner is {self.planner} and central.solver is {self.solver}; only one "
                "of them can plan: leave the other out"
            )
        if not 0.0 < self.solver_time <= MOST_SOLVER_TIME:
            raise ConfigError(
                f"central.solver_time is {self.solver_time:g} s; it must be more than 0 and at "
                f"most {MOST_SOLVER_TIME:g} s"
            )
        if self.planner not in PLANNERS:
            raise UnknownNameError("central.planner", self.planner, PLANNERS)
        for name in (
            "period",
            "least_period",
            "horizon",
            "expansions",
            "most_released",
            "most_queued",
        ):
            if getattr(self, name) < 1:
                raise ConfigError(f"central.{name} is {getattr(self, name)}; it must be 1 or more")

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
    check_keys(dict(texts), [item.name for item in fields(CentralConfig)], "central")
    try:
        return msgspec.convert(dict(texts), CentralConfig, strict=False)
    except msgspec.ValidationError as cause:
        raise ConfigError(f"central: {cause}") from None

"""How long a robot is served at a station: a constant time, or one drawn from a distribution."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from swarm_common.model.errors import ConfigError
from swarm_common.model.schema import Schema

# Parameters of each distribution [s].
PARAMETERS = {
    "constant": "[time]",
    "uniform": "[least, most]",
    "triangular": "[least, likeliest, most]",
    "lognormal": "[mean, deviation]",
}
LONGEST = 86_400.0  # [s]


@dataclass(frozen=True, slots=True)
class ServiceTime:
    """A distribution of times [s]; see `PARAMETERS`."""

    kind: str = "constant"
    values: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        is_ordered = list(self.values) == sorted(self.values)
        if self.kind in ("uniform", "triangular") and not is_ordered:
            raise ConfigError(f"service: {self.kind} is {list(self.values)}; expected {self.form}")
        if self.kind == "lognormal" and not self.values[0]:
            raise ConfigError("service: the mean of lognormal is 0 s; it must be positive")

    @property
    def form(self) -> str:
        """Meaning of the parameters."""
        return PARAMETERS[self.kind]

    @property
    def mean(self) -> float:
        """Expected time [s]."""
        if self.kind == "lognormal":
            return self.values[0]
        return sum(self.values) / len(self.values)

    def draw(self, rng: random.Random) -> float:
        """Return a time [s]."""
        match self.kind:
            case "uniform":
                return rng.uniform(*self.values)
            case "triangular":
                least, likeliest, most = self.values
                return rng.triangular(least, most, likeliest)
            case "lognormal":
                mean, deviation = self.values
                variance = math.log1p((deviation / mean) ** 2)  # of the time's logarithm
                return rng.lognormvariate(math.log(mean) - 0.5 * variance, math.sqrt(variance))
            case _:
                return self.values[0]


AT_ONCE = ServiceTime()
Seconds = Annotated[float, Meta(ge=0.0, le=LONGEST)]


class Distribution(Schema):
    """A distribution as files have it: one of its kinds."""

    constant: Seconds | tuple[Seconds] | None = None
    uniform: tuple[Seconds, Seconds] | None = None
    triangular: tuple[Seconds, Seconds, Seconds] | None = None
    lognormal: tuple[Seconds, Seconds] | None = None

    def time(self) -> ServiceTime:
        """Return the time."""
        given = {kind: values for kind in PARAMETERS if (values := getattr(self, kind)) is not None}
        if len(given) != 1:
            found = " and ".join(given) or "none"
            raise ConfigError(f"expected one of {', '.join(PARAMETERS)}; found {found}")
        ((kind, values),) = given.items()
        return ServiceTime(kind, values if isinstance(values, tuple) else (values,))


class ServiceEnds(Distribution, rename={"first": "from", "last": "to"}):
    """The key `service` of orders: a distribution, or both ends."""

    first: Seconds | Distribution | None = None
    last: Seconds | Distribution | None = None


def service_times(given: float | ServiceEnds) -> tuple[ServiceTime, ServiceTime]:
    """Return the times at the first and the last station of an order."""
    if not isinstance(given, ServiceEnds) or given.first is given.last is None:
        both = _time(given)
        return both, both
    return _time(given.first), _time(given.last)


def _time(given: float | Distribution | None) -> ServiceTime:
    return given.time() if isinstance(given, Distribution) else ServiceTime(values=(given or 0.0,))

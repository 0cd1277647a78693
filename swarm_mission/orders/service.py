"""How long a robot is served at a station: a constant time, or one drawn from a distribution."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

from swarm_common.files.yaml_io import number, numbers
from swarm_common.model.errors import ConfigError, UnknownNameError

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
        if any(not 0.0 <= value <= LONGEST for value in self.values):
            raise ConfigError(
                f"service is {list(self.values)} s; expected times from 0 to {LONGEST:g} s"
            )
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


def parse_service(content: object, what: str) -> tuple[ServiceTime, ServiceTime]:
    """Return the times at the first and the last station of an order.

    Args:
        content: A time, a distribution, or both ends by the keys `from` and `to`.
        what: Where it stands, for messages.

    Raises:
        ConfigError: If it is none of these.
    """
    if isinstance(content, dict) and content.keys() & {"from", "to"}:
        for key in content:
            if key not in ("from", "to"):
                raise UnknownNameError("key", str(key), ("from", "to"), what)
        first, last = (_parse_one(content.get(key, 0.0), f"{what}.{key}") for key in ("from", "to"))
        return first, last
    both = _parse_one(content, what)
    return both, both


def _parse_one(content: object, what: str) -> ServiceTime:
    try:
        if not isinstance(content, dict):
            return ServiceTime("constant", (number(content, what),))
        if len(content) != 1:
            raise ConfigError(f"{what} is {content!r}; expected one of {', '.join(PARAMETERS)}")
        ((kind, values),) = content.items()
        if kind not in PARAMETERS:
            raise UnknownNameError("distribution", str(kind), PARAMETERS, what)
        count = PARAMETERS[kind].count(",") + 1
        if kind == "constant" and not isinstance(values, list):
            values = [values]
        return ServiceTime(kind, numbers(values, count, f"{what}.{kind} {PARAMETERS[kind]}"))
    except UnknownNameError:
        raise
    except ConfigError as error:
        raise ConfigError(str(error) if what in str(error) else f"{what}: {error}") from None

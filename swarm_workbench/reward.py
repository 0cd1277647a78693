"""Reward of a step: named terms with weights, or a callable of one's own.

| term | usual weight | for each robot |
|---|---|---|
| `progress` | 1 | [m] by which it is nearer to its goal |
| `way` | 0 | [m] by which its shortest way is shorter; near walls, up to three times as much |
| `goal` | 10 | 1 where it is at its goal |
| `contact` | 10 | -1 where it touches something |
| `time` | 0.1 | minus the seconds of the step |
| `closeness` | 0 | minus the seconds, in full at 0 m from something, nought at 0.3 m |
| `smoothness` | 0 | minus the change of the wished twist, in shares of the most |
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import FloatArray, Mask
from swarm_common.model.schema import shown

CLOSE = 0.3  # [m] from something at which closeness begins


class StepOutcome(NamedTuple):
    """What happened in a step to each of n robots.

    Attributes:
        progress: (n,) [m] by which it is nearer to its goal.
        way_progress: (n,) [m] by which its way is shorter; zeros where nobody asks for it.
        reached: (n,) whether it is at its goal.
        contacts: (n,) whether it touches something.
        gaps: (n,) [m] to the nearest thing, at most 0.5.
        twists: (n, 3) vx, wz, vy as shares of the most, wished.
        former: (n, 3) twists of the step before.
        seconds: [s] that the step lasted.
    """

    progress: FloatArray
    way_progress: FloatArray
    reached: Mask
    contacts: Mask
    gaps: FloatArray
    twists: FloatArray
    former: FloatArray
    seconds: float


TERMS: Mapping[str, Callable[[StepOutcome], FloatArray]] = {
    "progress": lambda step: step.progress,
    "way": lambda step: step.way_progress,
    "goal": lambda step: step.reached.astype(np.float64),
    "contact": lambda step: -step.contacts.astype(np.float64),
    "time": lambda step: np.full(len(step.gaps), -step.seconds),
    "closeness": lambda step: -step.seconds * np.clip(1.0 - step.gaps / CLOSE, 0.0, 1.0),
    "smoothness": lambda step: -np.abs(step.twists - step.former).sum(axis=1),
}
WEIGHTS = {
    "progress": 1.0, "way": 0.0, "goal": 10.0, "contact": 10.0, "time": 0.1, "closeness": 0.0,
    "smoothness": 0.0,
}  # fmt: skip
OwnReward = Callable[[StepOutcome], Any]


def takes(given: Any, arguments: int) -> TypeGuard[Callable[..., Any]]:
    """Return whether something is a callable of so many arguments, as far as one can see."""
    if not callable(given):
        return False
    try:
        inspect.signature(given).bind(*range(arguments))
    except TypeError:
        return False
    except ValueError:  # a built-in one without a signature
        return True
    return True


class Reward:
    """Weighted sum of terms, or what a callable says.

    Attributes:
        needs_ways: Whether the progress along shortest ways counts.
    """

    def __init__(self, given: Mapping[str, float] | OwnReward | None) -> None:
        """Take weights by term in place of the usual ones, or a callable.

        Raises:
            ConfigError: If there is no such term, or a weight is no finite number.
        """
        self._own = given if takes(given, 1) else None
        weights = {} if given is None or self._own is not None else given
        if not isinstance(weights, Mapping):
            raise ConfigError(
                f"reward is {shown(given)}; expected weights by term, or a callable of an outcome"
            )
        for name, weight in weights.items():
            if name not in TERMS:
                raise UnknownNameError("term of the reward", str(name), TERMS)
            is_number = isinstance(weight, int | float) and not isinstance(weight, bool)
            if not is_number or not np.isfinite(weight):
                raise ConfigError(f"reward.{name} is {shown(weight)}; expected a finite number")
        self._weights = {**WEIGHTS, **weights}
        self.needs_ways = self._own is not None or self._weights["way"] != 0.0

    def of(self, step: StepOutcome) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return the rewards (n,), and of them the terms that have a weight.

        Raises:
            ConfigError: If the callable returns no n finite numbers.
        """
        if self._own is None:
            terms = {
                name: weight * TERMS[name](step) for name, weight in self._weights.items() if weight
            }
            return np.sum(list(terms.values()), axis=0) + np.zeros(len(step.gaps)), terms
        given = self._own(step)
        try:
            rewards = np.array(given, np.float64)
        except (TypeError, ValueError):
            rewards = np.zeros(0)
        if rewards.shape != step.gaps.shape or not np.isfinite(rewards).all():
            raise ConfigError(
                f"the callable that is the reward returns {shown(given)};"
                f" expected {len(step.gaps)} finite numbers"
            )
        return rewards, {}

"""Figures as they are worth, fit for JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


def rounded(value: Any) -> Any:
    """Return data with all numbers fit for JSON: four decimals, None for what is not finite.

    Args:
        value: A number, a text, None, or mappings of them.
    """
    if isinstance(value, float):
        return round(value, 4) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [rounded(item) for item in value]
    return value

"""Tables: a DataFrame where pandas is there, else a structured array."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def table(columns: Mapping[str, Sequence[Any]]) -> Any:
    """Return columns of the same length as a pandas.DataFrame, or as a structured array."""
    if importlib.util.find_spec("pandas") is not None:
        import pandas

        return pandas.DataFrame(columns)
    arrays = {name: np.asarray(values) for name, values in columns.items()}
    rows = len(next(iter(arrays.values()), ()))
    result = np.zeros(rows, [(name, array.dtype) for name, array in arrays.items()])
    for name, array in arrays.items():
        result[name] = array
    return result

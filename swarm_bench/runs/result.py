"""Lines of a bench's result file: a run's record, or why there is none."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from swarm_run.record.figures import rounded
from swarm_run.record.run_record import SCHEMA, ResultOrigin, RunRecord, record_from_json


class FailedRun(msgspec.Struct, frozen=True, kw_only=True):
    """A run without a result, and why; it is repeated when a bench goes on."""

    scenario: str
    method: str
    robots: int
    seed: int
    engine: str
    conditions: Mapping[str, Any]
    error: str  # in one line
    origin: ResultOrigin | None = None
    refused: bool = False  # whether the error is one of the user's input, such as a solver's plan

    def as_json(self) -> dict[str, Any]:
        """Return a dictionary for json.dump."""
        data = rounded(self)
        if not self.refused:
            del data["refused"]
        return {"schema": SCHEMA, **data}


def line_from_json(data: Mapping[str, Any]) -> RunRecord | FailedRun:
    """Return what a line of a result file says.

    Args:
        data: Without its schema.

    Raises:
        ValueError: If a field is missing, or of another type.
    """
    return msgspec.convert(data, FailedRun) if "error" in data else record_from_json(data)

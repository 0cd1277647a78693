"""A list of everything that is wrong with one thing, reported at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from swarm_common.model.errors import DescriptionError, SwarmError

LISTED = 50
"""So many faults are listed; of the others a message tells the number."""


class Faults:
    """Collects errors, so that the author of a file sees all of them at the first attempt."""

    def __init__(self, where: str, error: type[SwarmError]) -> None:
        """Start without any.

        Args:
            error: Class of the exception that tells of several.
        """
        self._where = where
        self._error = error
        self._found: dict[str, SwarmError] = {}

    def __bool__(self) -> bool:
        return bool(self._found)

    @contextmanager
    def caught(self) -> Iterator[None]:
        """Record the error that a block raises, and continue behind it."""
        try:
            yield
        except SwarmError as error:
            self.add(error)

    def add(self, error: SwarmError) -> None:
        """Record an error, each message once; one that tells of several counts as these."""
        for single in error.faults or (error,):
            if type(single) is DescriptionError:
                single = self._error(str(single))
            self._found.setdefault(str(single), single)

    def tell(self, messages: Iterable[str]) -> None:
        """Record messages as errors."""
        for message in messages:
            self.add(self._error(message))

    def check(self) -> None:
        """Raise the collected errors, if any: a single one unchanged, several as a list."""
        if not self._found:
            return
        faults = tuple(self._found.values())
        if len(faults) == 1:
            raise faults[0]
        start = f"{self._where}: "
        lines = [str(fault).removeprefix(start) for fault in faults[:LISTED]]
        if len(faults) > LISTED:
            lines.append(f"and {len(faults) - LISTED} more")
        message = f"{start}{len(faults)} things are wrong:"
        error = self._error("\n  - ".join([message, *lines]))
        error.faults = faults
        raise error from faults[0]

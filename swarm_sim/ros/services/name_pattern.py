"""Filters on names: POSIX extended regular expressions, matched in linear time by RE2.

`simulation_interfaces` says that filters are such expressions. They come from anybody, and a
matcher that backtracks, as Python's does, may need years for `(a+)+$`. RE2 (Cox 2010) follows all
ways through an expression at once, and refuses one that needs too much memory.
"""

from __future__ import annotations

from collections.abc import Iterable

import re2

from swarm_common.model.errors import SwarmError

LONGEST = 256  # letters of a pattern
MEMORY = 1 << 20  # [bytes] of a compiled pattern


class PatternError(SwarmError):
    """A filter is not a valid pattern, or needs too much memory."""


class NamePattern:
    """A pattern, ready to be held against names. A name matches if any part of it does."""

    def __init__(self, text: str) -> None:
        r"""Compile it.

        Args:
            text: In POSIX's syntax for extended regular expressions, with `\d`, `\w` and `\s`.
        """
        if len(text) > LONGEST:
            raise PatternError(f"it has {len(text)} letters; expected at most {LONGEST}")
        options = re2.Options()
        options.posix_syntax = options.perl_classes = options.one_line = True
        options.max_mem = MEMORY
        options.log_errors = False
        try:
            self._pattern = re2.compile(text, options)
        except (re2.error, UnicodeError) as error:
            raise PatternError(_reason(error)) from error

    def matching(self, names: Iterable[str]) -> list[str]:
        """Return those of some names that match."""
        return [name for name in names if self._pattern.search(name)]


def _reason(error: Exception) -> str:
    reason = error.args[0] if error.args else error
    return reason.decode("utf-8", "replace") if isinstance(reason, bytes) else str(reason)

"""A file of JSON lines, one per run, that a killed bench leaves readable and goes on with."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TextIO, TypeVar

from rich.console import Console

from swarm_common.model.errors import ConfigError

T = TypeVar("T")


def read_json_lines(path: Path, parse: Callable[[Any], T], command: str) -> list[T]:
    """Return the results in a file; see `numbered_json_lines`.

    Args:
        parse: Makes a result of a line's data without its schema.
        command: Command that writes such files, for the error.
    """
    return [result for _, result in numbered_json_lines(path, parse, command)]


def numbered_json_lines(path: Path, parse: Callable[[Any], T], command: str) -> list[tuple[int, T]]:
    """Return the results in a file, with the numbers of their lines.

    A line that a killed bench left unfinished does not count.

    Args:
        parse: Makes a result of a line's data without its schema.
        command: Command that writes such files, for the error.

    Raises:
        ConfigError: If the file cannot be read, or a complete line is not a result.
    """
    try:
        lines = path.read_text(encoding="utf-8").split("\n")
    except (OSError, UnicodeDecodeError) as cause:
        raise ConfigError(f"cannot read {path}: {cause}") from cause
    results = []
    for number, line in enumerate(lines[:-1], 1):  # what follows the last newline is unfinished
        if not line.strip():
            continue
        try:
            data = json.loads(line, parse_constant=_refuse)
            data.pop("schema", None)
            results.append((number, parse(data)))
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as cause:
            raise ConfigError(
                f"{path}, line {number} is no result of {command}: {cause}"
            ) from cause
    return results


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no number")


def open_to_append(path: Path) -> TextIO:
    """Open a result file; an unfinished last line is cut off.

    Args:
        path: Path of the file, which need not exist; its folder has to.

    Raises:
        ConfigError: If it cannot be written.
    """
    try:
        if path.is_file():
            data = path.read_bytes()
            if not data.endswith(b"\n"):
                path.write_bytes(data[: data.rfind(b"\n") + 1])
        return path.open("a", encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {path}: {cause}") from cause


def append_json_line(file: TextIO, data: Mapping[str, Any]) -> None:
    """Write one result, so that it is there whatever comes next.

    Args:
        data: Fit for JSON, without NaN and infinity.
    """
    file.write(json.dumps(data, allow_nan=False) + "\n")
    file.flush()


def collected(
    new: Iterable[T],
    file: Path | None,
    console: Console,
    line: Callable[[T], str],
    as_json: Callable[[T], Mapping[str, Any]],
) -> list[T]:
    """Print each result as it comes, add it to a file, and return all.

    Args:
        file: File of JSON lines; None to keep nothing.
        as_json: Returns what is kept of a result.
    """
    results = []
    with contextlib.ExitStack() as stack:
        output = stack.enter_context(open_to_append(file)) if file is not None else None
        for result in new:
            results.append(result)
            console.print(line(result), highlight=False, soft_wrap=True, markup=False)
            if output is not None:
                append_json_line(output, as_json(result))
    return results


def taken_over(count: int, total: int, file: Path | None) -> str:
    """Return what to say of runs that are not repeated, since a file has their results."""
    return (
        f"{count} of {total} runs are in {file} already; "
        "take another file after a change of code or scenario"
    )


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

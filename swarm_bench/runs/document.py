"""Parts of a document that a command writes, between two lines that mark them."""

from __future__ import annotations

from pathlib import Path

from swarm_common.model.errors import ConfigError


def replace_part(path: Path, name: str, text: str) -> None:
    """Put a text between the lines `<!-- NAME -->` and `<!-- /NAME -->` of a file.

    Args:
        path: The file; it is rewritten as a whole.
        text: Markdown; blank lines around it are set anew.

    Raises:
        ConfigError: If the file cannot be read or written, or does not have both lines once.
    """
    whole = with_part(path, name, text)
    try:
        path.write_text(whole, encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write to {path}: {cause}") from cause


def with_part(path: Path, name: str, text: str) -> str:
    """Return the content of a file with a part of it replaced, as `replace_part` would write it.

    Raises:
        ConfigError: If the file cannot be read, or does not have both lines once.
    """
    head, tail = _around_part(path, name)
    return f"{head}\n{text.strip()}\n\n{tail}"


def check_part(path: Path, name: str) -> None:
    """Look for a part of a file before long runs whose results are put there.

    Raises:
        ConfigError: If the file cannot be read or has no such part, as in `replace_part`.
    """
    _around_part(path, name)


def _around_part(path: Path, name: str) -> tuple[str, str]:
    """Return what comes before a part, with its first line, and from its last line on."""
    begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->"
    try:
        content = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as cause:
        raise ConfigError(f"cannot write to {path}: {cause}") from cause
    head, found, rest = content.partition(begin)
    _, closed, tail = rest.partition(end)
    if not found or not closed or begin in rest:
        raise ConfigError(
            f"{path} has no part '{name}': it needs a line {begin.strip()} and a line {end}"
        )
    return f"{head}{begin}", f"{end}{tail}"

"""Reads what the documents let a reader type: blocks under a mark in an HTML comment.

<!-- run -->             the next block is run by every test run
<!-- run long -->        by the long tests only
<!-- run background -->  by the long tests: started, and left running for the blocks after it
<!-- save NAME -->       the next block is the file NAME
<!-- not run: WHY -->    the next block is not run
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

MARK = re.compile(r"<!-- (run|save)(?: ([\w.]+))? -->")
NOT_RUN = re.compile(r"<!-- not run: .+ -->")


@dataclass(frozen=True)
class Block:
    """A marked block.

    Attributes:
        kind: "run", "long", "background" or "save".
        name: Of the file to save; else empty.
        text: The commands, or the contents of the file.
        line: Of the mark in the document, from 1 on.
    """

    kind: str
    name: str
    text: str
    line: int


def blocks_of(document: str) -> Iterator[Block]:
    """Yield the marked blocks of a document in their order.

    Raises:
        ValueError: If a mark is unknown or no block follows it.
    """
    lines = document.splitlines()
    for number, line in enumerate(lines):
        if not (match := MARK.fullmatch(line.strip())):
            continue
        verb, word = match.groups()
        kind = "save" if verb == "save" else word or "run"
        if kind not in ("run", "long", "background", "save"):
            raise ValueError(f"line {number + 1}: unknown mark {line.strip()}")
        text = "\n".join(_block(lines[number + 1 :]))
        if not text:
            raise ValueError(f"line {number + 1}: no block follows {line.strip()}")
        yield Block(kind, word if verb == "save" else "", text + "\n", number + 1)


def unmarked_fences(document: str) -> list[int]:
    """Return the lines, from 1 on, at which fenced blocks without any mark begin."""
    lines = document.splitlines()
    fences = [number for number, line in enumerate(lines) if line.startswith("```")]
    return [
        number + 1
        for number in fences[::2]
        if number == 0
        or not (MARK.fullmatch(lines[number - 1]) or NOT_RUN.match(lines[number - 1]))
    ]


def _block(lines: list[str]) -> list[str]:
    """Return the block that the lines begin with: fenced, or indented by four spaces."""
    while lines and not lines[0].strip():
        lines = lines[1:]
    if lines and lines[0].startswith("```"):
        return lines[1 : lines.index("```", 1)]
    found = []
    for line in lines:
        if not line.startswith("    "):
            break
        found.append(line[4:])
    return found

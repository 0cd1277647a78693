r"""Filters on names: POSIX extended regular expressions, matched in linear time.

`simulation_interfaces` says that filters are such expressions. They come from anybody, and a
matcher that backtracks, as Python's does, may need longer than the universe lasts for `(a+)+$`.
Here all ways through the expression are followed at once (Thompson 1968), so that a letter costs
at most one visit of each state; states and visits are limited, too.

Known: letters, `.`, `[a-z]`, `[^...]`, `[[:digit:]]`, `(...)`, `|`, `*`, `+`, `?`, `{m,n}`, `^`,
`$`, `\` before a special letter, and `\d`, `\w`, `\s`. A name matches if any part of it does.
"""

from __future__ import annotations

import string
from collections.abc import Iterable
from dataclasses import dataclass

from swarm_common.errors import SwarmError

LONGEST = 256  # letters of a pattern
DEEPEST = 20  # groups in groups
MOST_STATES = 500  # of the machine; repeats are written out
MOST_KNOWN = 1000  # steps that are remembered
MOST_VISITS = 300_000  # of states while one pattern looks for names
SPECIAL = "*+?{"
CLASSES = {
    "alpha": string.ascii_letters,
    "digit": string.digits,
    "alnum": string.ascii_letters + string.digits,
    "upper": string.ascii_uppercase,
    "lower": string.ascii_lowercase,
    "space": string.whitespace,
    "blank": " \t",
    "punct": string.punctuation,
    "xdigit": string.hexdigits,
}
ESCAPES = {
    "d": CLASSES["digit"],
    "w": CLASSES["alnum"] + "_",
    "s": CLASSES["space"],
}


class PatternError(SwarmError):
    """A filter is no pattern, or costs too much."""


@dataclass(frozen=True, slots=True)
class Letters:
    """One letter of a set, or one that is not in it."""

    ranges: tuple[tuple[str, str], ...]
    is_negated: bool = False

    def has(self, letter: str) -> bool:
        """Whether a letter matches."""
        return any(low <= letter <= high for low, high in self.ranges) is not self.is_negated


@dataclass(frozen=True, slots=True)
class Edge:
    """Beginning or end of a name."""

    is_end: bool


@dataclass(frozen=True, slots=True)
class Sequence:
    """One after the other."""

    parts: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several."""

    parts: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Repeat:
    """From `least` to `most` times; None is any number of times."""

    part: Node
    least: int
    most: int | None


Node = Letters | Edge | Sequence | Choice | Repeat
OTHERS: dict[str, Node] = {
    "^": Edge(is_end=False),
    "$": Edge(is_end=True),
    ".": Letters((), is_negated=True),
}


def _letters(text: str, *, is_negated: bool = False) -> Letters:
    return Letters(tuple((letter, letter) for letter in text), is_negated)


class _Parser:
    """Recursive descent; groups in groups are limited, so the recursion is, too."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0

    def parse(self) -> Node:
        node = self._choice(0)
        if self._at < len(self._text):
            raise PatternError(f"')' at letter {self._at + 1} closes nothing")
        return node

    def _peek(self) -> str:
        return self._text[self._at : self._at + 1]

    def _next(self, what: str) -> str:
        letter = self._peek()
        if not letter:
            raise PatternError(f"it ends within {what}")
        self._at += 1
        return letter

    def _choice(self, depth: int) -> Node:
        if depth > DEEPEST:
            raise PatternError(f"groups are nested more than {DEEPEST} deep")
        parts = [self._sequence(depth)]
        while self._peek() == "|":
            self._at += 1
            parts.append(self._sequence(depth))
        return parts[0] if len(parts) == 1 else Choice(tuple(parts))

    def _sequence(self, depth: int) -> Node:
        parts: list[Node] = []
        while self._peek() not in ("", "|", ")"):
            parts.append(self._repeated(self._atom(depth)))
        return Sequence(tuple(parts))

    def _repeated(self, node: Node) -> Node:
        while (letter := self._peek()) and letter in SPECIAL:
            self._at += 1
            if letter == "{":
                least, most = self._counts()
            else:
                least, most = {"*": (0, None), "+": (1, None), "?": (0, 1)}[letter]
            if isinstance(node, Repeat) and None is node.most is most and node.least + least <= 1:
                node = Repeat(node.part, min(node.least, least), None)  # a** is a*
            else:
                node = Repeat(node, least, most)
                _check_size(node)
        return node

    def _counts(self) -> tuple[int, int | None]:
        end = self._text.find("}", self._at)
        body = self._text[self._at : end] if end >= 0 else ""
        least, comma, most = body.partition(",")
        if not least.isdecimal() or not (most == "" or most.isdecimal()) or len(body) > 7:
            raise PatternError("expected {m}, {m,} or {m,n}")
        self._at = end + 1
        last = int(least) if not comma else (int(most) if most else None)
        if last is not None and last < int(least):
            raise PatternError(f"{{{body}}} ends before it begins")
        return int(least), last

    def _atom(self, depth: int) -> Node:
        letter = self._next("a pattern")
        if letter == "(":
            node = self._choice(depth + 1)
            if self._peek() != ")":
                raise PatternError("a '(' is not closed")
            self._at += 1
            return node
        if letter == "[":
            return self._bracket()
        if letter == "\\":
            escaped = self._next("an escape")
            return _letters(ESCAPES.get(escaped, escaped))
        if letter in SPECIAL:
            raise PatternError(f"'{letter}' at letter {self._at} repeats nothing")
        return OTHERS.get(letter, _letters(letter))

    def _bracket(self) -> Node:
        what = "[...]"
        is_negated = self._peek() == "^"
        self._at += is_negated
        ranges: list[tuple[str, str]] = []
        is_first = True
        while (letter := self._next(what)) != "]" or is_first:
            is_first = False
            if letter == "[" and self._peek() == ":":
                ranges += self._class()
                continue
            last = letter
            if self._peek() == "-" and self._text[self._at + 1 : self._at + 2] not in ("]", ""):
                self._at += 1
                last = self._next(what)
            if last < letter:
                raise PatternError(f"the range {letter}-{last} ends before it begins")
            ranges.append((letter, last))
        return Letters(tuple(ranges), is_negated)

    def _class(self) -> list[tuple[str, str]]:
        end = self._text.find(":]", self._at)
        name = self._text[self._at + 1 : end] if end >= 0 else ""
        if name not in CLASSES:
            raise PatternError(f"expected one of {', '.join(f'[:{known}:]' for known in CLASSES)}")
        self._at = end + 2
        return [(letter, letter) for letter in CLASSES[name]]


def _size(node: Node) -> int:
    """Return at least how many states a part needs."""
    if isinstance(node, Sequence | Choice):
        return 2 + sum(_size(part) for part in node.parts) + len(node.parts)
    if isinstance(node, Repeat):
        times = node.least + 1 if node.most is None else max(node.most, 1)
        return times * (_size(node.part) + 2)
    return 1


def _check_size(node: Node) -> None:
    if _size(node) > MOST_STATES:
        raise PatternError(f"its repeats, written out, need more than {MOST_STATES} states")


class NamePattern:
    """A pattern, ready to be held against names."""

    def __init__(self, text: str) -> None:
        """Compile it.

        Raises:
            PatternError: If it is none, or too large.
        """
        if len(text) > LONGEST:
            raise PatternError(f"it has {len(text)} letters; expected at most {LONGEST}")
        node = _Parser(text).parse()
        _check_size(node)
        self._tests: list[Letters | Edge | None] = []  # of a state; None: only ways on
        self._ways: list[tuple[int, ...]] = []
        self._visits = 0
        self._known: dict[tuple[frozenset[int], str], frozenset[int]] = {}
        self._end = self._state(None)
        self._start = self._build(node, self._end)

    def matching(self, names: Iterable[str]) -> list[str]:
        """Return those of some names that match.

        Raises:
            PatternError: If that takes too many steps.
        """
        self._visits = 0
        return [name for name in names if self._finds(name)]

    # The machine

    def _state(self, test: Letters | Edge | None, *ways: int) -> int:
        self._tests.append(test)
        self._ways.append(ways)
        return len(self._tests) - 1

    def _build(self, node: Node, then: int) -> int:
        """Return the first state of a part that goes on to `then`."""
        if isinstance(node, Letters | Edge):
            return self._state(node, then)
        if isinstance(node, Sequence):
            for part in reversed(node.parts):
                then = self._build(part, then)
            return then
        if isinstance(node, Choice):
            return self._state(None, *(self._build(part, then) for part in node.parts))
        if node.most is None:
            loop = self._state(None)
            self._ways[loop] = (self._build(node.part, loop), then)
            then = loop
        for _ in range((node.most or node.least) - node.least):
            then = self._state(None, self._build(node.part, then), then)
        for _ in range(node.least):
            then = self._build(node.part, then)
        return then

    def _finds(self, name: str) -> bool:
        """Whether any part of a name matches."""
        states = self._closure(frozenset((self._start,)), is_first=True)
        for letter in name:
            if self._end in states:
                return True
            states = self._after(states, letter)
        states = self._closure(states, is_first=not name, is_last=True)
        return self._end in states

    def _after(self, states: frozenset[int], letter: str) -> frozenset[int]:
        """Return the states behind a letter, beginning anew included."""
        key = (states, letter)
        if key not in self._known:
            if len(self._known) >= MOST_KNOWN:
                self._known.clear()
            following = {self._start}
            for state in states:
                test = self._tests[state]
                if isinstance(test, Letters) and test.has(letter):
                    following.update(self._ways[state])
            self._visits += len(states)
            self._known[key] = self._closure(frozenset(following))
        self._visits += 1
        return self._known[key]

    def _closure(
        self, states: frozenset[int], *, is_first: bool = False, is_last: bool = False
    ) -> frozenset[int]:
        """Return all states that are reached without a letter."""
        reached, waiting = set(states), list(states)
        while waiting:
            self._visits += 1
            state = waiting.pop()
            test = self._tests[state]
            if isinstance(test, Letters):
                continue
            if isinstance(test, Edge) and not (is_last if test.is_end else is_first):
                continue
            fresh = [way for way in self._ways[state] if way not in reached]
            reached.update(fresh)
            waiting += fresh
        if self._visits > MOST_VISITS:
            raise PatternError("it takes too many steps; use a simpler one")
        return frozenset(reached)

"""Mutations of text files as careless hands and broken tools make them."""

import re
from collections.abc import Callable

from hypothesis import strategies as st

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")
WORD = re.compile(r"[A-Za-z_]{3,}")
ODD_NUMBERS = (
    "nan", "inf", "-inf", "-1", "0", "-0.0", "1e308", "1e-320", "99999999999999999999", "0.5",
    "1 2 3", "", "abc", "0x10", "1_000", "true", "null", "[]", "{}", "1e5", "-1e-9",
)  # fmt: skip
ODD_TEXT = (
    "\x00", "é", "<", ">", "&", '"', "'", "${", "}", "$(find ", "$(arg x)", "<!--", "-->", ":",
    "- ", "\t", "{", "]", "#", "&a", "*a", "!!python/object:os.system", "..", "/", "%s", "\\",
    "\ud7ff",
)  # fmt: skip
Edit = Callable[[str], str]


def _spot(pattern: re.Pattern[str], place: int, put: str) -> Edit:
    def edit(text: str) -> str:
        spots = list(pattern.finditer(text))
        if not spots:
            return text
        spot = spots[place % len(spots)]
        return text[: spot.start()] + put + text[spot.end() :]

    return edit


def _word(place: int, source: int) -> Edit:
    def edit(text: str) -> str:
        words = WORD.findall(text)
        return _spot(WORD, place, words[source % len(words)])(text) if words else text

    return edit


def _lines(first: int, second: int, kind: str) -> Edit:
    def edit(text: str) -> str:
        lines = text.split("\n")
        a, b = first % len(lines), second % len(lines)
        if kind == "swap":
            lines[a], lines[b] = lines[b], lines[a]
        elif kind == "drop":
            del lines[a]
        else:
            lines.insert(b, lines[a])
        return "\n".join(lines)

    return edit


def _cut(start: int, length: int, put: str) -> Edit:
    def edit(text: str) -> str:
        a = start % (len(text) + 1)
        return text[:a] + put + text[a + length :]

    return edit


PLACE = st.integers(0, 10_000)
EDITS = st.one_of(
    st.builds(_spot, st.just(NUMBER), PLACE, st.sampled_from(ODD_NUMBERS)),
    st.builds(_word, PLACE, PLACE),
    st.builds(_lines, PLACE, PLACE, st.sampled_from(("swap", "drop", "copy"))),
    st.builds(_cut, PLACE, st.integers(0, 40), st.sampled_from(("", *ODD_TEXT))),
)


def mutated(*texts: str) -> st.SearchStrategy[str]:
    """Return a strategy of one of the texts with one to four edits."""

    def apply(text: str, edits: list[Edit]) -> str:
        for edit in edits:
            text = edit(text)
        return text

    return st.builds(apply, st.sampled_from(texts), st.lists(EDITS, min_size=1, max_size=4))

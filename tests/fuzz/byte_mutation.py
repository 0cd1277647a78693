"""Files with faults in them: seeds that hypothesis edits by bytes, numbers and words."""

import os
import re

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "0")) or 60  # of each kind of file
FUZZ = settings(
    max_examples=EXAMPLES,
    deadline=None,
    database=None,
    derandomize=EXAMPLES <= 1000,
    suppress_health_check=list(HealthCheck),
)
NUMBER = re.compile(rb"-?\d+(\.\d+)?")
WORD = re.compile(rb"[A-Za-z_]{3,}")
VALUES = [
    *(b"0", b"-1", b"1e9", b"1e-9", b"nan", b"inf", b"-inf", b"1e400", b"9" * 400, b"", b"1 2"),
    *(
        b"x",
        b"<",
        b">",
        b"&",
        b"&#0;",
        b"\x00",
        b"\xff\xfe",
        b"]]>",
        b"[",
        b"{",
        b"}",
        b": ",
        b"- ",
    ),
    *(b"\n", b"*a", b"&a", b"!!python/object:os.system", b"2001-99-99", b"../../..", b"model://x"),
    *(b"<model name='m'>", b"</model>", b"<link/>", b"<pose/>", b"<include/>", b"<mesh/>"),
]
EDITS = st.lists(
    st.tuples(
        st.sampled_from(["cut", "copy", "number", "word", "insert", "byte", "swap"]),
        st.floats(0.0, 1.0, exclude_max=True),
        st.floats(0.0, 1.0, exclude_max=True),
        st.sampled_from(VALUES),
    ),
    max_size=5,
)
Edit = tuple[str, float, float, bytes]


def mutated(data: bytes, edits: list[Edit]) -> bytes:
    """Return data with faults."""
    for kind, first, second, value in edits:
        at, to = int(first * len(data)), int(second * len(data))
        low, high = min(at, to), max(at, to)
        if kind == "cut":
            data = data[:low] + data[min(high, low + 80) :]
        elif kind == "copy":
            data = data[:at] + data[low : low + 200] + data[at:]
        elif kind == "swap":
            data = (
                data[:low] + data[high : high + 40] + data[low + 40 : high] + data[low : low + 40]
            )
        elif kind == "byte":
            data = data[:at] + bytes([int(second * 256)]) + data[at + 1 :]
        elif kind == "insert":
            data = data[:at] + value + data[at:]
        else:
            found = list((NUMBER if kind == "number" else WORD).finditer(data))
            if found:
                match = found[int(first * len(found))]
                other = found[int(second * len(found))].group() if kind == "word" else value
                data = data[: match.start()] + other + data[match.end() :]
    return data

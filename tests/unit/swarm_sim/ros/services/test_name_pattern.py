"""Filters mean what Python's regular expressions mean, in linear time."""

import random
import re
import time

import pytest

from swarm_sim.ros.services.inquiries import LONGEST, NamePattern, PatternError

ATOMS = ("a", "b", ".", "[ab]", "[^a]", "[a-c]", r"\d", "x", r"\.")
REPEATS = ("*", "+", "?", "{2}", "{1,2}", "{0,3}", "{1,}", "{0}", "**")


def make_pattern(rng, depth=0):
    draw = rng.random()
    if depth > 3 or draw < 0.4:
        return rng.choice(ATOMS)
    inner = make_pattern(rng, depth + 1)
    if draw < 0.6:
        return inner + make_pattern(rng, depth + 1)
    if draw < 0.7:
        return f"({inner}|{make_pattern(rng, depth + 1)})"
    if draw < 0.9:
        return f"({inner}){rng.choice(REPEATS)}"
    return f"^{inner}" if draw < 0.95 else f"{inner}$"


def test_it_finds_what_the_regular_expressions_of_python_find():
    rng = random.Random(0)
    compared = 0
    while compared < 3000:
        text = make_pattern(rng)
        pattern = NamePattern(text)
        twin = re.compile(text.replace("**", "*"))
        names = ["".join(rng.choices("abcx1.", k=rng.randrange(8))) for _ in range(5)]
        found = pattern.matching(names)
        assert found == [name for name in names if twin.search(name)], text
        compared += 1


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("", ["Srobot1", "Srobot12", "crate_2"]),
        ("2$", ["Srobot12", "crate_2"]),
        ("^Srobot[[:digit:]]{1}$", ["Srobot1"]),
        ("(crate|pallet)_", ["crate_2"]),
        ("[]2]", ["Srobot12", "crate_2"]),
    ],
)
def test_filters_that_people_write(text, names):
    assert NamePattern(text).matching(["Srobot1", "Srobot12", "crate_2"]) == names


@pytest.mark.parametrize(
    "text",
    [
        "(", ")", "[", "[a", "a{3,1}", "*a", "[z-a]", "[[:no:]]", "a\\", "(?i)a",
        "(" * 5000, "[" * 5000, "a" * (LONGEST + 1),
        "((((a{99}){99}){99}){99}){99}", "(a{255}){255}",
    ],
)  # fmt: skip
def test_what_is_no_pattern_or_too_large_is_refused(text):
    with pytest.raises(PatternError):
        NamePattern(text)


@pytest.mark.parametrize(
    "text", ["(a+)+$", "(a|a)*b", "(.*)*x", "(a|b)*a(a|b){12}c", "(a?){60}a{60}", "((a*)*)*$"]
)
def test_no_pattern_takes_long(text):
    names = ["a" * 63 + "!"] * 300 + ["ab" * 32, "ba" * 32]
    started = time.process_time()
    NamePattern(text).matching(names)
    assert time.process_time() - started < 2.0  # where Python's would take years

"""The door for settings: what is refused, in which words, and that nothing else ever comes out."""

import contextlib
import dataclasses
import math
import pickle
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Meta

from swarm_common.files.convert import convert, located, read
from swarm_common.model.errors import ConfigError, MapError, SwarmError, UnknownNameError
from swarm_common.model.schema import (
    Count,
    Name,
    NotNegative,
    Point,
    PoseNumbers,
    Positive,
    Schema,
    Share,
)


class Color(Enum):
    RED = "red"
    BLUE = "blue"


class Place(NamedTuple):
    x: float
    y: float


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    radius: Positive = 0.1
    width: float = 0.1

    def __post_init__(self):
        if self.width > self.radius:
            raise ConfigError(f"width is {self.width} m; it must be at most the radius")


class Circle(Schema, tag_field="form", tag="circle"):
    radius: Positive


class Box(Schema, tag_field="form", tag="box"):
    size: Point


class Stop(Schema, rename={"from_": "from"}):
    from_: Name
    pose: PoseNumbers = (0.0, 0.0, 0.0)
    wait: NotNegative = 0.0
    loss: Share = 0.0
    count: Count = 1
    order: Literal["random", "as_written"] = "as_written"
    color: Color = Color.RED
    is_open: bool = False
    wheel: Wheel = Wheel()
    at: Place | None = None
    form: Circle | Box | None = None
    names: tuple[Name, ...] | Name = ()
    limits: Annotated[dict[Count, Positive], Meta(min_length=1)] | None = None
    path: Annotated[tuple[Point, ...], Meta(min_length=2)] | None = None
    size: float | str = 1.0
    anything: Any = None


class Route(Schema):
    stops: dict[Name, Stop] = msgspec.field(default_factory=dict)
    legs: tuple[Stop, ...] = ()


GOOD: dict[str, Any] = {
    "stops": {
        "a": {
            "from": "01", "pose": [1, 2, 3], "wait": 1, "loss": 0.5, "count": 3, "order": "random",
            "color": "blue", "is_open": True, "wheel": {"radius": 1, "width": 1}, "at": [1, 2.5],
            "form": {"form": "box", "size": [1, 2]}, "names": ["x", "y"], "limits": {"3": 4},
            "path": [[1, 2], [3, 4]], "size": "large", "anything": [None],
        }
    },
    "legs": [{"from": "b", "names": "x"}],
}  # fmt: skip


def test_a_value_that_fits_is_read_as_it_is_written():
    route = convert(GOOD, Route)
    stop = route.stops["a"]
    assert (stop.from_, stop.pose, stop.wait) == ("01", (1.0, 2.0, 3.0), 1.0)
    assert (stop.color, stop.wheel, stop.at) == (Color.BLUE, Wheel(radius=1.0, width=1.0), (1, 2.5))
    assert (stop.form, stop.limits) == (Box(size=(1.0, 2.0)), {3: 4.0})
    assert route.legs[0].names == "x"
    route = convert(GOOD, Route)
    assert convert(msgspec.to_builtins(route, str_keys=True), Route) == route


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"wait": -1}, "f.yaml: legs[1].wait is -1; expected a number, 0 or more"),
        ({"wait": True}, "wait is True; expected a number, 0 or more"),
        ({"wait": math.inf}, "wait is inf; expected a number, 0 or more"),
        (
            {"wheel": {"radius": 1, "width": 1e308}},
            "legs[1].wheel.width is 1e+308; expected a number, at most 1e+300 in size",
        ),
        ({"count": True}, "count is True; expected an integer, 1 or more"),
        ({"loss": 1}, "loss is 1; expected a number, 0 or more and less than 1"),
        ({"from": " a"}, "from is ' a'; expected text on one line, without blanks around it"),
        ({"pose": [1, 2]}, "pose is [1, 2]; expected a list of 3 numbers [x, y, yaw]"),
        ({"pose": [1, 2, 90]}, "pose[2] is 90; expected a number from -2 pi to 2 pi, in radians"),
        ({"order": "randon"}, "unknown order 'randon' in f.yaml: legs[1]; did you mean 'random'?"),
        ({"is_open": 1}, "is_open is 1; expected true or false"),
        ({"wheel": {"radios": 1}}, "unknown key 'radios' in f.yaml: legs[1].wheel; did you mean"),
        ({"wheel": {"width": 1}}, "f.yaml: legs[1].wheel: width is 1.0 m; it must be at most the"),
        ({"at": [1]}, "at is [1]; expected a list of 2 numbers"),
        ({"form": {"size": [1, 2]}}, "form lacks form; expected one of circle, box"),
        ({"form": {"form": "box"}}, "f.yaml: legs[1].form lacks size"),
        ({"names": ["a", ""]}, "names[1] is ''; expected text on one line"),
        ({"limits": {"0": 1}}, "legs[1].limits has the key 0; expected an integer, 1 or more"),
        ({"limits": {"9" * 40: 1}}, "expected an integer, 1 or more"),
        ({"limits": {"3": 0}}, "legs[1].limits.3 is 0; expected a number, more than 0"),
        ({"path": [[1, 2]]}, "path is [[1, 2]]; expected a list of 2 or more items, each a list"),
        ({"size": None}, "size is None; expected a number or text"),
        ({"form_": 1}, "unknown key 'form_' in f.yaml: legs[1]; did you mean"),
    ],
)
def test_what_does_not_fit_is_told_with_its_place(change, message):
    data = {"legs": [{"from": "b"}, {"from": "b"} | change]}
    with pytest.raises(ConfigError) as caught:
        convert(data, Route, Path("f.yaml"))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_what_lacks_or_is_no_mapping_is_told():
    for value, message in (
        ({"legs": [{}]}, "f: legs[0] lacks from"),
        ({"legs": {}}, "f: legs is {}; expected a list of items, each {from: ...}"),
        ({"stops": {" ": {}}}, "f: stops has the key ' '; expected text on one line"),
        ([], "f is []; expected 'key: value' lines"),
        ({1: 2}, "unknown key '1' in f"),
        (object(), "expected 'key: value' lines"),
    ):
        with pytest.raises(ConfigError) as caught:
            convert(value, Route, Path("f"))
        assert message in str(caught.value)


def test_texts_become_numbers_where_they_may():
    wheel = convert({"radius": "2", "width": "1e0"}, Wheel, "wheel", strict=False)
    assert wheel == Wheel(radius=2.0, width=1.0)
    for text in ("nan", "-1", "two", "1e999"):
        with pytest.raises(ConfigError, match=r"wheel.radius is .*; expected a number, more than"):
            convert({"radius": text}, Wheel, "wheel", strict=False)


def test_the_line_of_a_file_is_told(tmp_path):
    path = tmp_path / "r.yaml"
    for text, message in (
        ("legs:\n- from: 01\n- from: a\n  wait: -1\n", "r.yaml, line 4: legs[1].wait is -1"),
        ("legs:\n- from: 01\n- from: a\n  weit: 1\n", "in .*r.yaml, line 4: legs[1]; did you"),
        ("legs:\n- from: 01\n- wait: 1\n", "r.yaml, line 3: legs[1] lacks from"),
        ("stops:\n  a: &a {from: b, wait: -1}\nlegs: [*a]\n", "line 2: stops.a.wait is -1"),
        ("b: 1\n", "unknown key 'b' in .*r.yaml, line 1"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(ConfigError, match=message.replace("[", r"\[")):
            read(path, Route)


def test_texts_are_as_written(tmp_path):
    path = tmp_path / "r.yaml"
    path.write_text("legs: [{from: 01, names: [yes, null], size: 1}]\nstops: {no: {from: 1e3}}\n")
    route = read(path, Route)
    leg = route.legs[0]
    assert (leg.from_, leg.names, leg.size) == ("01", ("yes", "null"), 1.0)
    assert route.stops["no"].from_ == "1e3"


def test_the_error_asked_for_is_raised():
    with pytest.raises(MapError, match="is 5"):
        convert(5, Route, "map", MapError)
    with pytest.raises(MapError, match=r"map\.wheel: width"):
        convert({"from": "a", "wheel": {"width": 1}}, Stop, "map", MapError)
    with pytest.raises(UnknownNameError, match=r"unknown thing 'x' in here; known: other"):
        with located("here"):
            raise UnknownNameError("thing", "x", ["other"])
    with pytest.raises(MapError, match=r"^here: wrong$"):
        with located("here", MapError):
            raise ConfigError("wrong")


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
    | st.sampled_from([10**400, "circle", "random", "red"]),
    lambda below: st.lists(below, max_size=4)
    | st.dictionaries(
        st.text(max_size=5) | st.sampled_from([*GOOD, *GOOD["stops"]["a"], "radius", "3"]),
        below,
        max_size=4,
    ),
    max_leaves=12,
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(values)
def test_any_value_ends_in_a_value_or_in_an_error_of_ours(value):
    for kind in (Route, Stop, dict[str, Stop], tuple[Stop | None, ...], Wheel):
        for strict in (True, False):
            with contextlib.suppress(SwarmError):
                found = convert(value, kind, "here", strict=strict)
                assert convert(msgspec.to_builtins(found, str_keys=True), kind) == found


def test_what_nests_too_deep_is_refused():
    value: Any = 1
    for _ in range(100_000):
        value = [value]
    assert convert(value, Any) is value
    with pytest.raises(ConfigError, match="nested too deep"):
        convert(value, Route)

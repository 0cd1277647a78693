"""Words in which settings are declared, and the comparison of values with them.

`swarm_common.files.convert` reads settings. The description of a `Meta` says what is expected; its
`check` is a predicate beside the constraints that msgspec has.
"""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, dataclass_transform

import msgspec
from msgspec import Meta, inspect

from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError

LARGEST = 1e300  # of numbers
FEW = 8  # names that are listed
LONGEST_DIGITS = 18  # of a key that is a number
MAX_SHOWN = 200  # characters of a value in a message
PLURALS = (("a number", "numbers"), ("an integer", "integers"), ("text", "texts"))
Steps = tuple[str | int, ...]  # keys, and indices of items, from the top to a value
TOP: Steps = ()


def is_name(text: str) -> bool:
    """Whether messages, tables and commands can show a name: one line, not empty."""
    return bool(text) and text == text.strip() and text.isprintable()


def _is_angle(value: float) -> bool:
    return abs(value) <= math.tau + 1e-6


def told(words: str, check: Callable[[Any], bool] | None = None, **limits: Any) -> Meta:
    """Return a constraint with what is expected in words.

    Args:
        check: Predicate beside the limits that msgspec has.
    """
    return Meta(description=words, extra=check and {"check": check}, **limits)


Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
Share = Annotated[float, Meta(ge=0.0, lt=1.0)]
Count = Annotated[int, Meta(ge=1)]
Seed = Annotated[int, told("an integer from 0 to 2^63 - 1", ge=0, le=2**63 - 1)]
Name = Annotated[str, told("text on one line, without blanks around it", is_name)]
# a larger one may be in degrees
Yaw = Annotated[float, told("a number from -2 pi to 2 pi, in radians", _is_angle)]
Point = Annotated[tuple[float, float], told("a list of 2 numbers [x, y]")]
PoseNumbers = Annotated[tuple[float, float, Yaw], told("a list of 3 numbers [x, y, yaw]")]
Polygon = Annotated[tuple[Point, ...], told("a list of at least 3 points [x, y]", min_length=3)]


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(msgspec.field,))
class Schema(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of what is read from files: immutable, and no other keys than its fields."""


def shown(value: object) -> str:
    """Return a value for a message: short, also if it is a huge number."""
    text = repr(value) if not isinstance(value, int) or abs(value) < LARGEST else "a huge number"
    return text if len(text) <= MAX_SHOWN else text[:MAX_SHOWN] + " ..."


class Misfit(Exception):
    """A value does not fit.

    Attributes:
        steps: Its place, as messages have it.
        told: What is wrong, or the error that a class raised.
        at: Place whose line is told.
    """

    def __init__(self, steps: Steps, told: str | SwarmError, at: Steps | None = None) -> None:
        self.steps, self.told, self.at = steps, told, steps if at is None else at

    def error(self, where: str | Path, error: type[SwarmError]) -> SwarmError:
        """Return the error for the user."""
        place = place_of(where, self.steps)
        if isinstance(self.told, SwarmError):
            return with_place(self.told, place, error)
        return error(f"{place or 'the value'} {self.told}")


def with_place(cause: SwarmError, place: str, error: type[SwarmError]) -> SwarmError:
    """Return an error with a place in its message, which it may have already."""
    if isinstance(cause, UnknownNameError):
        inner = cause.where
        is_told = inner.startswith(place) or place.startswith(inner)
        where = max(inner, place, key=len) if is_told else f"{place}: {inner}"
        return UnknownNameError(cause.kind, cause.name, cause.known, where)
    text = str(cause)
    return cause if not place or text.startswith(place) else error(f"{place}: {text}")


def place_of(where: str | Path, steps: Steps) -> str:
    """Return a place like `FILE: stations.a[0]`."""
    path = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)
    if isinstance(where, Path) and path:
        return f"{where}: {path.removeprefix('.')}"
    return f"{where}{path}" if str(where) else path.removeprefix(".")


_shape_of_class = functools.cache(inspect.type_info)


def shape_of(kind: Any) -> Any:
    """Return a type as msgspec describes it."""
    return _shape_of_class(kind) if isinstance(kind, type) else inspect.type_info(kind)


def check_fields(
    settings: object, owner: str = "", names: Mapping[str, str] = MappingProxyType({})
) -> None:
    """Refuse a field beyond its constraints: for `__post_init__` of what programs make, too.

    Args:
        owner: What stands before the names of fields in messages, like `planner.`.
        names: Names of fields in messages that are others than in the class.

    Raises:
        ConfigError: For the first such field.
    """
    for field in shape_of(type(settings)).fields:
        try:
            name = names.get(field.name, field.name)
            check(getattr(settings, field.name), field.type, (name,))
        except Misfit as fault:
            raise fault.error(owner.removesuffix("."), ConfigError) from None


def check(
    value: Any, shape: Any, steps: Steps, *, strict: bool = True, makes: bool = False
) -> None:
    """Compare a value, and all below it, with a shape; raise `Misfit` for the first that is off.

    Args:
        makes: Whether to make every value on the way, to find the one that its class refuses.
    """
    asked, checks = shape, list[Any]()
    while isinstance(shape, inspect.Metadata | inspect.UnionType):
        if isinstance(shape, inspect.UnionType):
            shape = _member(value, shape, asked, steps)
        else:
            checks += [shape.extra["check"]] if shape.extra else []
            shape = shape.type
    if hasattr(shape, "cls") and isinstance(value, shape.cls):
        return
    if isinstance(value, str) and not strict and type(shape) in SCALARS:
        with contextlib.suppress(msgspec.ValidationError):
            value = msgspec.convert(value, SCALARS[type(shape)], strict=False)
    if choices := choices_of(shape):
        _check_choice(value, choices, asked, steps)
    elif not _fits(value, shape):
        raise _unlike(value, asked, steps)
    for step, item, kind in _children(value, shape, steps):
        check(item, kind, (*steps, step), strict=strict, makes=makes)
    if not all(each(value) for each in checks):
        raise _unlike(value, asked, steps)
    if makes and hasattr(shape, "cls"):
        try:
            msgspec.convert(value, shape.cls, strict=strict, str_keys=True)
        except SwarmError as cause:
            raise Misfit(steps, cause) from None


def _unlike(value: object, asked: Any, steps: Steps) -> Misfit:
    is_huge = isinstance(value, int | float) and LARGEST < abs(value) < math.inf
    limit = f", at most {LARGEST:g} in size" if is_huge else ""
    return Misfit(steps, f"is {shown(value)}; expected {_words(asked)}{limit}")


SCALARS: dict[type, type] = {inspect.IntType: int, inspect.FloatType: float, inspect.BoolType: bool}
TEXTS = (inspect.StrType, inspect.LiteralType, inspect.EnumType)
_NUMBERS = (inspect.IntType, inspect.FloatType)
KEYED = (inspect.StructType, inspect.DataclassType, inspect.TypedDictType)
LISTED = (inspect.ListType, inspect.VarTupleType, inspect.SetType, inspect.FrozenSetType)
_ROWS = (inspect.TupleType, inspect.NamedTupleType)


def _member(value: Any, shape: inspect.UnionType, asked: Any, steps: Steps) -> Any:
    """Return the member of a union that a value is meant to be of."""
    found: list[Any] = [each for each in shape.types if _is_like(value, bare(each))]
    tagged = {each.tag: each for each in found if getattr(each, "tag", None) is not None}
    if tagged:
        field = found[0].tag_field
        if field not in value:
            raise Misfit(steps, f"lacks {field}; expected one of {', '.join(map(str, tagged))}")
        _check_choice(value[field], list(tagged), asked, (*steps, field))
        return tagged[value[field]]
    if not found:
        raise _unlike(value, asked, steps)
    return next((each for each in found if _fits(value, bare(each))), found[0])


def _is_like(value: Any, shape: Any) -> bool:
    """Whether a value is of the same sort as a shape: a number, a text, a list, a mapping."""
    if isinstance(shape, inspect.UnionType):
        return any(_is_like(value, bare(each)) for each in shape.types)
    match value:
        case None:
            return isinstance(shape, inspect.NoneType)
        case bool():
            return isinstance(shape, inspect.BoolType)
        case int() | float():
            return isinstance(shape, _NUMBERS)
        case str():
            return isinstance(shape, TEXTS)
        case list() | tuple():
            return isinstance(shape, LISTED + _ROWS) or getattr(shape, "array_like", False)
    return isinstance(value, Mapping) and isinstance(shape, (*KEYED, inspect.DictType))


def bare(shape: Any) -> Any:
    """Return a shape without what is said of it."""
    return bare(shape.type) if isinstance(shape, inspect.Metadata) else shape


def _fits(value: Any, shape: Any) -> bool:
    """Whether a value is of a shape, whatever stands below it."""
    if isinstance(shape, inspect.UnionType):
        return any(_fits(value, bare(each)) for each in shape.types)
    if isinstance(shape, (inspect.NoneType, inspect.BoolType, *_NUMBERS, *TEXTS)):
        is_like = _is_like(value, shape)
        if isinstance(shape, inspect.IntType):
            is_like = is_like and isinstance(value, int)
        return is_like and _is_within(value, shape)
    if isinstance(shape, KEYED + LISTED + _ROWS) or isinstance(shape, inspect.DictType):
        length = len(_row(shape))
        is_length = not length or (isinstance(value, list | tuple) and len(value) == length)
        return _is_like(value, shape) and is_length and _is_within(value, shape)
    return True  # msgspec decides


def _row(shape: Any) -> Sequence[Any]:
    """Return the kinds of the items of a list of fixed length; none for other shapes."""
    if isinstance(shape, inspect.TupleType):
        return shape.item_types
    is_row = isinstance(shape, inspect.NamedTupleType) or getattr(shape, "array_like", False)
    return [field.type for field in shape.fields] if is_row else []


def _is_within(value: Any, shape: Any) -> bool:
    """Whether a number, or the length of anything else, is within the limits of a shape."""
    if isinstance(shape, _NUMBERS):
        low = value >= (-LARGEST if shape.ge is None else shape.ge)
        high = value <= (LARGEST if shape.le is None else shape.le)
        is_above = shape.gt is None or value > shape.gt
        return low and high and is_above and (shape.lt is None or value < shape.lt)
    least, most = getattr(shape, "min_length", None), getattr(shape, "max_length", None)
    return least is most is None or (least or 0) <= len(value) <= (most or math.inf)


def choices_of(shape: Any) -> Sequence[Any]:
    """Return the values of a shape that is a choice; none for other shapes."""
    if isinstance(shape, inspect.EnumType):
        return [each.value for each in shape.cls]
    return shape.values if isinstance(shape, inspect.LiteralType) else ()


def _check_choice(value: Any, choices: Sequence[Any], asked: Any, steps: Steps) -> None:
    if any(type(value) is type(each) and value == each for each in choices):
        return
    name = next((step for step in reversed(steps) if isinstance(step, str)), "value")
    if not isinstance(value, str):
        raise _unlike(value, asked, steps)
    unknown = UnknownNameError(name, value[:MAX_SHOWN], map(str, choices))
    raise Misfit(steps[:-1], unknown, steps)


def _children(value: Any, shape: Any, steps: Steps) -> Iterator[tuple[str | int, Any, Any]]:
    """Yield step, value and kind of all that stands right below a value."""
    if kinds := _row(shape):
        yield from zip(range(len(kinds)), value, kinds, strict=True)
    elif isinstance(shape, LISTED):
        yield from ((i, item, shape.item_type) for i, item in enumerate(value))
    elif isinstance(shape, inspect.DictType):
        for key, item in value.items():
            _check_key(key, shape.key_type, steps)
            yield str(key), item, shape.value_type
    elif isinstance(shape, KEYED):
        known = {field.encode_name: field for field in shape.fields}
        tag = getattr(shape, "tag_field", None)
        for key in value:
            if key not in known and (tag is None or key != tag):
                unknown = UnknownNameError("key", str(key)[:MAX_SHOWN], known)
                raise Misfit(steps, unknown, (*steps, str(key)))
        missing = [key for key, field in known.items() if field.required and key not in value]
        if missing:
            raise Misfit(steps, f"lacks {', '.join(missing)}")
        yield from ((key, item, known[key].type) for key, item in value.items() if key in known)


def _check_key(key: Any, kind: Any, steps: Steps) -> None:
    is_number = isinstance(bare(kind), inspect.IntType) and isinstance(key, str)
    if is_number and key.isascii() and key.isdecimal() and len(key) <= LONGEST_DIGITS:
        key = int(key)
    try:
        check(key, kind, TOP)
    except Misfit:
        told = f"has the key {shown(key)}; expected {_words(kind)}"
        raise Misfit(steps, told, (*steps, str(key))) from None


def _words(shape: Any) -> str:
    """Return what is expected."""
    match shape:
        case inspect.Metadata(extra_json_schema={"description": str(words)}):
            return words
        case inspect.Metadata():
            return _words(shape.type)
        case inspect.UnionType():
            kinds = [each for each in shape.types if not isinstance(each, inspect.NoneType)]
            return " or ".join(dict.fromkeys(map(_words, kinds)))
        case inspect.BoolType():
            return "true or false"
        case inspect.IntType() | inspect.FloatType():
            kind = "an integer" if isinstance(shape, inspect.IntType) else "a number"
            return kind + _range(shape)
        case inspect.StrType():
            return "text"
        case inspect.LiteralType() | inspect.EnumType():
            return "one of " + ", ".join(map(str, choices_of(shape)))
        case _ if row := _row(shape):
            return f"a list of {len(row)} {_plural(row[0])}"
        case _ if isinstance(shape, LISTED):
            least = f"{shape.min_length} or more " if shape.min_length else ""
            return f"a list of {least}{_plural(shape.item_type)}"
        case _ if isinstance(shape, KEYED):
            required = [field.encode_name for field in shape.fields if field.required]
            if required:
                return "{" + ", ".join(f"{name}: ..." for name in required) + "}"
            names = [field.encode_name for field in shape.fields]
            return "'key: value' lines" + (f" ({', '.join(names)})" if len(names) <= FEW else "")
    return "'name: value' lines"


def _plural(shape: Any) -> str:
    words = _words(shape)
    for one, several in PLURALS:
        if words.startswith(one):
            return several + words.removeprefix(one)
    return f"items, each {words}"


def _range(shape: Any) -> str:
    least = "" if shape.ge is None else f"{shape.ge:g} or more"
    least = least if shape.gt is None else f"more than {shape.gt:g}"
    most = "" if shape.le is None else f"at most {shape.le:g}"
    most = most if shape.lt is None else f"less than {shape.lt:g}"
    if shape.ge is not None and shape.le is not None:
        return f" from {shape.ge:.12g} to {shape.le:.12g}"
    limits = " and ".join(filter(None, (least, most)))
    return f", {limits}" if limits else ""

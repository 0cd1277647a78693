"""The one door for settings: values of YAML, JSON or a program become typed values, or ConfigError.

A kind is a `Schema` with constraints (`swarm_common.model.schema`), or any other type that
`msgspec.convert` makes. What does not fit is refused in words of ours: file, line and place, what
was found, what is expected, and the nearest name for a misspelt one:

    class Stop(Schema):
        station: Name
        wait: NotNegative = 0.0  # [s]

    read(Path("stop.yaml"), Stop)
    # stop.yaml, line 2: wait is -1; expected a number, 0 or more
    # unknown key 'stations' in stop.yaml, line 1; did you mean 'station'?

True and false are no numbers; whole numbers do for floats; nan, infinities and numbers beyond 1e300
are refused wherever a number is asked. Texts in files are as written where nothing but a text is
asked (`station: 01`). What a class refuses in `__post_init__` is told with its place.
"""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import yaml
from msgspec import inspect

from swarm_common.files.yaml_io import LARGEST, MAX_SHOWN, parse_yaml, read_text, shown, yaml_nodes
from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError

Kind = TypeVar("Kind")
Steps = tuple[str | int, ...]  # keys, and indices of items, from the top to a value
TOP: Steps = ()
LONGEST_DIGITS = 18  # of a key that is a number
PLURALS = (("a number", "numbers"), ("an integer", "integers"), ("text", "texts"))


class _Fault(Exception):
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
        place = _place(where, self.steps)
        if isinstance(self.told, SwarmError):
            return _at(self.told, place, error)
        return error(f"{place or 'the value'} {self.told}")


def _at(cause: SwarmError, place: str, error: type[SwarmError]) -> SwarmError:
    """Return an error with a place in its message, which it may have already."""
    if isinstance(cause, UnknownNameError):
        return UnknownNameError(cause.kind, cause.name, cause.known, cause.where or place)
    text = str(cause)
    return cause if not place or text.startswith(place) else error(f"{place}: {text}")


def _place(where: str | Path, steps: Steps) -> str:
    """Return a place like `FILE: stations.a[0]`."""
    path = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)
    if isinstance(where, Path) and path:
        return f"{where}: {path.removeprefix('.')}"
    return f"{where}{path}" if str(where) else path.removeprefix(".")


@contextlib.contextmanager
def located(where: object, error: type[SwarmError] = ConfigError) -> Iterator[None]:
    """Put a place before the messages of configuration errors that are raised within."""
    try:
        yield
    except (ConfigError, error) as cause:
        raise _at(cause, str(where), error) from None


def convert(
    value: object,
    kind: type[Kind],
    where: str | Path = "",
    error: type[SwarmError] = ConfigError,
    *,
    strict: bool = True,
) -> Kind:
    """Return a value as the kind that is asked.

    Args:
        where: Place of the value for messages: a path is a file, a text a place in one.
        strict: Whether texts are neither numbers nor truth values.

    Raises:
        SwarmError: `error`, or UnknownNameError for a key or a choice that does not exist.
    """
    try:
        return _converted(value, kind, strict)
    except _Fault as fault:
        raise fault.error(where, error) from None


def read(
    path: Path,
    kind: type[Kind],
    error: type[SwarmError] = ConfigError,
    *,
    may_be_empty: bool = False,
) -> Kind:
    """Return the content of a YAML file as the kind that is asked; see `yaml_io.read_yaml`.

    Raises:
        SwarmError: As of `convert`, with the line; or if the file cannot be read or parsed.
    """
    text = read_text(path, error)
    places = tuple(_texts(_shape(kind), ""))
    data = parse_yaml(text, path, error, may_be_empty=may_be_empty, as_written=places)
    try:
        return _converted(data, kind, strict=True)
    except _Fault as fault:
        line = _line(yaml_nodes(text), fault.at)
        raise fault.error(Path(f"{path}, line {line}"), error) from None


def _converted(value: object, kind: type[Kind], strict: bool) -> Kind:
    try:
        _check(value, _shape(kind), TOP, strict)
        return msgspec.convert(value, kind, strict=strict, str_keys=True)
    except SwarmError as cause:
        _check(value, _shape(kind), TOP, strict, makes=True)
        raise _Fault(TOP, cause) from None
    except RecursionError:
        raise _Fault(TOP, "is nested too deep") from None
    except (msgspec.ValidationError, OverflowError) as cause:
        raise _Fault(TOP, f"is unusable: {cause}") from None


@functools.cache
def _shape_of_class(kind: type) -> inspect.Type:
    return inspect.type_info(kind)


def _shape(kind: Any) -> inspect.Type:
    return _shape_of_class(kind) if isinstance(kind, type) else inspect.type_info(kind)


def _check(value: Any, shape: Any, steps: Steps, strict: bool, *, makes: bool = False) -> None:
    """Compare a value, and all below it, with a shape; raise `_Fault` for the first that is off.

    Args:
        makes: Whether to make every value on the way, to find the one that its class refuses.
    """
    words, checks = _words(shape), []
    while isinstance(shape, inspect.Metadata | inspect.UnionType):
        if isinstance(shape, inspect.UnionType):
            shape = _member(value, shape, words, steps)
        else:
            checks += [shape.extra["check"]] if shape.extra else []
            shape = shape.type
    if isinstance(value, str) and not strict and type(shape) in _SCALARS:
        with contextlib.suppress(msgspec.ValidationError):
            value = msgspec.convert(value, _SCALARS[type(shape)], strict=False)
    if choices := _choices(shape):
        _check_choice(value, choices, words, steps)
    elif not _fits(value, shape) or not all(check(value) for check in checks):
        raise _Fault(steps, f"is {shown(value)}; expected {words}")
    for step, item, kind in _children(value, shape, steps):
        _check(item, kind, (*steps, step), strict, makes=makes)
    if makes and hasattr(shape, "cls"):
        try:
            msgspec.convert(value, shape.cls, strict=strict, str_keys=True)
        except SwarmError as cause:
            raise _Fault(steps, cause) from None


_SCALARS: dict[type, type] = {
    inspect.IntType: int,
    inspect.FloatType: float,
    inspect.BoolType: bool,
}
_TEXTS = (inspect.StrType, inspect.LiteralType, inspect.EnumType)
_NUMBERS = (inspect.IntType, inspect.FloatType)
_KEYED = (inspect.StructType, inspect.DataclassType, inspect.TypedDictType)
_LISTED = (inspect.ListType, inspect.VarTupleType, inspect.SetType, inspect.FrozenSetType)
_ROWS = (inspect.TupleType, inspect.NamedTupleType)


def _member(value: Any, shape: inspect.UnionType, words: str, steps: Steps) -> Any:
    """Return the member of a union that a value is meant to be of."""
    found: list[Any] = [each for each in shape.types if _is_like(value, _bare(each))]
    tagged = {each.tag: each for each in found if getattr(each, "tag", None) is not None}
    if tagged:
        field = found[0].tag_field
        if field not in value:
            raise _Fault(steps, f"lacks {field}; expected one of {', '.join(map(str, tagged))}")
        _check_choice(value[field], list(tagged), words, (*steps, field))
        return tagged[value[field]]
    if not found:
        raise _Fault(steps, f"is {shown(value)}; expected {words}")
    return next((each for each in found if _fits(value, _bare(each))), found[0])


def _is_like(value: Any, shape: Any) -> bool:
    """Whether a value is of the same sort as a shape: a number, a text, a list, a mapping."""
    match value:
        case None:
            return isinstance(shape, inspect.NoneType)
        case bool():
            return isinstance(shape, inspect.BoolType)
        case int() | float():
            return isinstance(shape, _NUMBERS)
        case str():
            return isinstance(shape, _TEXTS)
        case list() | tuple():
            return isinstance(shape, _LISTED + _ROWS) or getattr(shape, "array_like", False)
    return isinstance(shape, (*_KEYED, inspect.DictType))


def _bare(shape: Any) -> Any:
    return _bare(shape.type) if isinstance(shape, inspect.Metadata) else shape


def _fits(value: Any, shape: Any) -> bool:
    """Whether a value is of a shape, whatever stands below it."""
    if isinstance(shape, inspect.AnyType):
        return True
    if isinstance(shape, (inspect.NoneType, inspect.BoolType, *_NUMBERS, *_TEXTS)):
        is_like = _is_like(value, shape)
        if isinstance(shape, inspect.IntType):
            is_like = is_like and isinstance(value, int)
        return is_like and _is_within(value, shape)
    if isinstance(shape, _KEYED + _LISTED + _ROWS) or isinstance(shape, inspect.DictType):
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


def _choices(shape: Any) -> Sequence[Any]:
    if isinstance(shape, inspect.EnumType):
        return [each.value for each in shape.cls]
    return shape.values if isinstance(shape, inspect.LiteralType) else ()


def _check_choice(value: Any, choices: Sequence[Any], words: str, steps: Steps) -> None:
    if any(type(value) is type(each) and value == each for each in choices):
        return
    name = next((step for step in reversed(steps) if isinstance(step, str)), "value")
    if not isinstance(value, str):
        raise _Fault(steps, f"is {shown(value)}; expected {words}")
    unknown = UnknownNameError(name, value[:MAX_SHOWN], map(str, choices))
    raise _Fault(steps[:-1], unknown, steps)


def _children(value: Any, shape: Any, steps: Steps) -> Iterator[tuple[str | int, Any, Any]]:
    """Yield step, value and kind of all that stands right below a value."""
    if kinds := _row(shape):
        yield from (
            (i, item, kind) for i, (item, kind) in enumerate(zip(value, kinds, strict=True))
        )
    elif isinstance(shape, _LISTED):
        yield from ((i, item, shape.item_type) for i, item in enumerate(value))
    elif isinstance(shape, inspect.DictType):
        for key, item in value.items():
            _check_key(key, shape.key_type, steps)
            yield str(key), item, shape.value_type
    elif isinstance(shape, _KEYED):
        known = {field.encode_name: field for field in shape.fields}
        tag = getattr(shape, "tag_field", None)
        for key in value:
            if key not in known and (tag is None or key != tag):
                unknown = UnknownNameError("key", str(key)[:MAX_SHOWN], known)
                raise _Fault(steps, unknown, (*steps, str(key)))
        missing = [key for key, field in known.items() if field.required and key not in value]
        if missing:
            raise _Fault(steps, f"lacks {', '.join(missing)}")
        yield from ((key, item, known[key].type) for key, item in value.items() if key in known)


def _check_key(key: Any, kind: Any, steps: Steps) -> None:
    is_number = isinstance(_bare(kind), inspect.IntType) and isinstance(key, str)
    if is_number and key.isascii() and key.isdecimal() and len(key) <= LONGEST_DIGITS:
        key = int(key)
    try:
        _check(key, kind, TOP, strict=True)
    except _Fault:
        told = f"has the key {shown(key)}; expected {_words(kind)}"
        raise _Fault(steps, told, (*steps, str(key))) from None


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
            return "one of " + ", ".join(map(str, _choices(shape)))
        case _ if row := _row(shape):
            return f"a list of {len(row)} {_plural(row[0])}"
        case _ if isinstance(shape, _LISTED):
            least = f"{shape.min_length} or more " if shape.min_length else ""
            return f"a list of {least}{_plural(shape.item_type)}"
        case _ if isinstance(shape, _KEYED):
            required = [field.encode_name for field in shape.fields if field.required]
            return ", ".join(required) or "'key: value' lines"
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


def _texts(shape: Any, place: str) -> Iterator[str]:
    """Yield the places of a shape that hold nothing but texts, for `parse_yaml`."""
    shape = _bare(shape)
    if isinstance(shape, inspect.UnionType):
        kinds = [_bare(each) for each in shape.types]
        if not any(type(each) in _SCALARS for each in kinds):
            for each in kinds:
                yield from _texts(each, place)
    elif isinstance(shape, _TEXTS) and all(isinstance(each, str) for each in _choices(shape)):
        yield place
    elif isinstance(shape, (*_LISTED, inspect.DictType)):
        below = shape.value_type if isinstance(shape, inspect.DictType) else shape.item_type
        yield from _texts(below, f"{place}.*".removeprefix("."))
    elif isinstance(shape, _KEYED):
        for field in shape.fields:
            yield from _texts(field.type, f"{place}.{field.encode_name}".removeprefix("."))


def _line(node: yaml.Node | None, steps: Steps) -> int:
    """Return the line of a place, or of the nearest above that is written out."""
    line = 1
    for step in steps:
        if isinstance(node, yaml.MappingNode):
            entry = next(((k, v) for k, v in node.value if k.value == step), None)
        elif isinstance(node, yaml.SequenceNode) and isinstance(step, int):
            entry = (node.value[step], node.value[step])
        else:
            entry = None
        if entry is None:
            break
        line, node = entry[0].start_mark.line + 1, entry[1]
    return line

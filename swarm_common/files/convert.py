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
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar, overload

import msgspec
import yaml
from msgspec import inspect

from swarm_common.files.yaml_io import parse_yaml, read_text, yaml_nodes
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.schema import (
    KEYED,
    LISTED,
    SCALARS,
    TEXTS,
    TOP,
    Misfit,
    Steps,
    bare,
    check,
    choices_of,
    shape_of,
    with_place,
)

Kind = TypeVar("Kind")


@contextlib.contextmanager
def located(where: object, error: type[SwarmError] = ConfigError) -> Iterator[None]:
    """Put a place before the messages of configuration errors that are raised within."""
    try:
        yield
    except (ConfigError, error) as cause:
        raise with_place(cause, str(where), error) from None


@overload
def convert(value: object, kind: type[Kind], *place: Any, **options: Any) -> Kind: ...
@overload
def convert(value: object, kind: Any, *place: Any, **options: Any) -> Any: ...
def convert(
    value: object,
    kind: Any,
    where: str | Path = "",
    error: type[SwarmError] = ConfigError,
    *,
    strict: bool = True,
) -> Any:
    """Return a value as the kind that is asked.

    Args:
        where: Place of the value for messages: a path is a file, a text a place in one.
        strict: Whether texts are neither numbers nor truth values.

    Raises:
        SwarmError: `error`, or UnknownNameError for a key or a choice that does not exist.
    """
    try:
        return _converted(value, kind, strict)
    except Misfit as fault:
        raise fault.error(where, error) from None


def read(
    path: Path,
    kind: type[Kind],
    error: type[SwarmError] = ConfigError,
    *,
    may_be_empty: bool = False,
    prepare: Callable[[dict[str, Any]], dict[str, Any]] = dict,
) -> Kind:
    """Return the content of a YAML file as the kind that is asked; see `yaml_io.read_yaml`.

    Args:
        prepare: Returns the content with what the file writes in a shorter form.

    Raises:
        SwarmError: As of `convert`, with the line; or if the file cannot be read or parsed.
    """
    text = read_text(path, error)
    places = tuple(texts_of(kind))
    data = parse_yaml(text, path, error, may_be_empty=may_be_empty, as_written=places)
    try:
        return _converted(prepare(data), kind, strict=True)
    except Misfit as fault:
        line = f", line {_line(yaml_nodes(text), fault.at)}" if fault.at else ""
        raise fault.error(Path(f"{path}{line}"), error) from None


def updated(
    base: Kind, data: object, where: str | Path = "", error: type[SwarmError] = ConfigError
) -> Kind:
    """Return a copy of a dataclass in which the values of a tree of keys replace its own."""
    return convert(over(asdict(base), data), type(base), where, error)  # type: ignore[call-overload]


def over(base: Mapping[str, Any], data: object) -> object:
    """Return a mapping with what it lacks from another one, on all levels."""
    if not isinstance(data, Mapping):
        return data
    given = {
        key: over(base[key], value) if isinstance(base.get(key), Mapping) else value
        for key, value in data.items()
    }
    return {**base, **given}


def _converted(value: object, kind: type[Kind], strict: bool) -> Kind:
    try:
        check(value, shape_of(kind), TOP, strict=strict)
        return msgspec.convert(value, kind, strict=strict, str_keys=True)
    except SwarmError as cause:
        check(value, shape_of(kind), TOP, strict=strict, makes=True)
        raise Misfit(TOP, cause) from None
    except RecursionError:
        raise Misfit(TOP, "is nested too deep") from None
    except (msgspec.ValidationError, OverflowError) as cause:
        raise Misfit(TOP, f"is unusable: {cause}") from None


def texts_of(kind: Any) -> Iterator[str]:
    """Yield the places in a kind that hold nothing but texts, for `parse_yaml`."""
    return _texts(shape_of(kind), "")


def _texts(shape: Any, place: str) -> Iterator[str]:
    shape = bare(shape)
    if isinstance(shape, inspect.UnionType):
        kinds = [bare(each) for each in shape.types]
        if not any(type(each) in SCALARS for each in kinds):
            for each in kinds:
                yield from _texts(each, place)
    elif isinstance(shape, TEXTS) and all(isinstance(each, str) for each in choices_of(shape)):
        yield place
    elif isinstance(shape, (*LISTED, inspect.DictType)):
        below = shape.value_type if isinstance(shape, inspect.DictType) else shape.item_type
        yield from _texts(below, f"{place}.*".removeprefix("."))
    elif isinstance(shape, KEYED):
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

"""Strict reading of YAML files: malformed text, unknown keys and wrong types are errors."""

from __future__ import annotations

import contextlib
import itertools
import re
from collections.abc import Callable, Sequence
from operator import methodcaller
from pathlib import Path
from typing import Any, cast

import yaml

from swarm_common.model.errors import ConfigError, SwarmError

SHORT, FEW = 20_000, 200  # characters, openings
LONGEST = 4_000_000  # [bytes] of a file
MOST_NODES = 2_000_000  # of a document in which each alias is replaced by what it stands for
INTEGER, FLOAT, TIMESTAMP, TEXT, NOTHING, MERGE = (
    f"tag:yaml.org,2002:{kind}" for kind in ("int", "float", "timestamp", "str", "null", "merge")
)


class NamedKeys:
    """For a loader of PyYAML: keys are names, as written, and each occurs once.

    Other texts that are names, like those in lists of stations, are as written where
    `as_written` says so: `01`, `yes`, `1.10` and `null` are no numbers and no booleans there.
    """

    as_written: Sequence[str] = ()  # places like `route.*.stations.*`, see `read_yaml`

    def get_single_node(self) -> yaml.Node | None:
        """Return the document, or raise if writing it out would never end."""
        document: yaml.Node | None = super().get_single_node()  # type: ignore[misc]
        if document is not None:
            _count(document, {})
            _name_keys(document, set())
            for place in self.as_written:
                _keep_texts(document, place.split("."))
        return document


class NamedKeyLoader(NamedKeys, yaml.SafeLoader):
    """PyYAML's safe loader with named keys."""


class FastLoader(NamedKeys, getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """The same in C, which is ten times faster but has no limit to how deep it nests."""


def _integer(loader: Any, node: yaml.ScalarNode) -> int:
    """Return a number that ROS can hold, or raise."""
    value: int = loader.construct_yaml_int(node)
    if not -(2**63) <= value < 2**63:
        raise yaml.MarkedYAMLError(
            problem="an integer of more than 64 bits", problem_mark=node.start_mark
        )
    return value


# PyYAML's rules are those of YAML 1.1, but nobody here writes times of day (12:30) or dates, and
# 1e-3 is a number in YAML 1.2, and to Nav2.
for _loader in (NamedKeyLoader, FastLoader):
    _loader.add_constructor(INTEGER, _integer)
    _loader.yaml_implicit_resolvers = {
        first: [(tag, form) for tag, form in forms if tag not in (INTEGER, FLOAT, TIMESTAMP)]
        for first, forms in _loader.yaml_implicit_resolvers.items()
    }
    _loader.add_implicit_resolver(
        INTEGER,
        re.compile(r"^[-+]?(0b[01_]+|0[0-7_]+|0|[1-9][0-9_]*|0x[0-9a-fA-F_]+)$"),
        list("-+0123456789"),
    )
    _loader.add_implicit_resolver(
        FLOAT,
        re.compile(
            r"^([-+]?(\d[\d_]*\.[\d_]*|\.\d[\d_]*)([eE][-+]?\d+)?|[-+]?\d+[eE][-+]?\d+"
            r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$"
        ),
        list("-+.0123456789"),
    )


def _name_keys(node: yaml.Node, done: set[int]) -> None:
    """Make texts of all keys below a node; raise if one is none, or occurs twice in a mapping."""
    if id(node) in done or isinstance(node, yaml.ScalarNode):
        return
    done.add(id(node))
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _name_keys(item, done)
        return
    lines: dict[str, int] = {}
    for index, (key, value) in enumerate(node.value):
        _name_keys(value, done)
        if key.tag == MERGE:
            continue
        if not isinstance(key, yaml.ScalarNode):
            raise yaml.MarkedYAMLError(
                problem="a key is a list or a mapping; expected a name", problem_mark=key.start_mark
            )
        if key.value in lines:
            raise yaml.MarkedYAMLError(
                problem=f"key '{key.value}' occurs twice, first in line {lines[key.value]}",
                problem_mark=key.start_mark,
            )
        lines[key.value] = key.start_mark.line + 1
        node.value[index] = (_text_node(key), value)


def _keep_texts(node: yaml.Node, place: Sequence[str]) -> None:
    """Make texts of the scalars at a place below a node; nothing stays nothing."""
    step, *rest = place
    if not isinstance(node, yaml.CollectionNode):
        return
    is_mapping = isinstance(node, yaml.MappingNode)
    for index, item in enumerate(node.value):
        key, value = item if is_mapping else (None, item)
        if key is not None and key.tag == MERGE:
            merged = value.value if isinstance(value, yaml.SequenceNode) else [value]
            for one in merged:
                _keep_texts(one, place)
        elif step == "*" or (key is not None and key.value == step):
            if rest:
                _keep_texts(value, rest)
            elif isinstance(value, yaml.ScalarNode) and (value.value or value.tag != NOTHING):
                text = _text_node(value)
                node.value[index] = (key, text) if is_mapping else text


def _text_node(node: yaml.ScalarNode) -> yaml.ScalarNode:
    """Return a node of the same text; the old one may stand elsewhere, too, by an alias."""
    return yaml.ScalarNode(TEXT, node.value, node.start_mark, node.end_mark, node.style)


def _count(node: yaml.Node, known: dict[int, int]) -> int:
    """Return the number of nodes below a node, itself included; aliases count like copies."""
    if id(node) not in known:
        known[id(node)] = MOST_NODES  # found there again: it contains itself
        children = node.value if isinstance(node, yaml.CollectionNode) else ()
        if isinstance(node, yaml.MappingNode):
            children = itertools.chain.from_iterable(children)
        known[id(node)] = 1 + sum(_count(child, known) for child in children)
    if known[id(node)] >= MOST_NODES:
        raise yaml.MarkedYAMLError(
            problem=f"aliases make more than {MOST_NODES} values of it",
            problem_mark=node.start_mark,
        )
    return known[id(node)]


def _is_shallow(text: str) -> bool:
    """Report whether a text is too short, and has too few brackets, to nest deep."""
    openings = sum(text.count(opening) for opening in "[{-?")
    return len(text) < SHORT and openings < FEW


def _read(text: str, as_written: Sequence[str], ask: Callable[[Any], Any]) -> Any:
    """Return what `ask` gets of the loader that reads a text: the same loader for all."""
    if _is_shallow(text):
        with contextlib.suppress(yaml.YAMLError):  # the other one says better where it is
            return _load(text, FastLoader, as_written, ask)
    return _load(text, NamedKeyLoader, as_written, ask)


def _load(text: str, kind: type[Any], as_written: Sequence[str], ask: Callable[[Any], Any]) -> Any:
    loader = kind(text)
    loader.as_written = as_written
    try:
        return ask(loader)
    finally:
        loader.dispose()


def read_yaml(
    path: Path,
    error: type[SwarmError] = ConfigError,
    *,
    may_be_empty: bool = False,
    as_written: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the mapping at the top of a YAML file; see `read_text` and `parse_yaml`."""
    return parse_yaml(
        read_text(path, error), path, error, may_be_empty=may_be_empty, as_written=as_written
    )


def read_text(path: Path, error: type[SwarmError] = ConfigError) -> str:
    """Return the content of a text file of any length up to `LONGEST`.

    Raises:
        SwarmError: `error`, naming the file, if it cannot be read.
    """
    try:
        with path.open("rb") as file:  # which may be a pipe
            content = file.read(LONGEST + 1)
        text = content.decode() if len(content) <= LONGEST else ""
    except OSError as cause:
        raise error(f"cannot read {path}: {cause}") from cause
    except UnicodeDecodeError as cause:
        at = content.count(b"\n", 0, cause.start) + 1
        raise error(f"{path}, line {at}: it is not UTF-8; save it as UTF-8") from cause
    if not text and content:
        raise error(f"{path} has more than {LONGEST // 1_000_000} MB; expected lines of YAML")
    return text


def parse_yaml(
    text: str,
    where: object,
    error: type[SwarmError] = ConfigError,
    *,
    may_be_empty: bool = False,
    as_written: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the mapping at the top of a YAML document; all keys are texts as written.

    Args:
        where: Name of the document in messages.
        may_be_empty: Whether a document without any key is an empty mapping, not an error.
        as_written: Places whose values are names or paths, and so texts as written: keys with dots
            between them, `*` for all keys or items.

    Raises:
        SwarmError: `error`, naming document and line, if it cannot be parsed.
    """
    try:
        data = _read(text, as_written, methodcaller("get_single_data"))
    except yaml.MarkedYAMLError as cause:
        mark = cause.problem_mark
        place = f"{where}, line {mark.line + 1}" if mark else str(where)
        raise error(f"{place}: malformed YAML: {cause.problem}") from cause
    except (yaml.YAMLError, ValueError, TypeError, OverflowError, RecursionError) as cause:
        what = "nested too deep" if isinstance(cause, RecursionError) else str(cause).split("\n")[0]
        raise error(f"{where}: malformed YAML: {what}") from cause
    if data is None and may_be_empty:
        return {}
    if data is None:
        raise error(f"{where} is empty; expected 'key: value' lines")
    if not isinstance(data, dict):
        raise error(f"{where}: expected 'key: value' lines, found {type(data).__name__}")
    return data


def yaml_nodes(text: str) -> yaml.Node | None:
    """Return a document that `parse_yaml` has read, as nodes with their lines."""
    return cast("yaml.Node | None", _read(text, (), methodcaller("get_single_node")))

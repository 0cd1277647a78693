"""YAML files read strictly: an error names file, line and key instead of guessing."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from swarm_common.errors import ConfigError, UnknownNameError


class _StrictLoader(yaml.SafeLoader):
    """Safe loader that refuses a key written twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[Hashable] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)  # type: ignore[no-untyped-call]
            if isinstance(key, Hashable):
                if key in seen:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"the key '{key}' is there twice", key_node.start_mark
                    )
                seen.add(key)
        return super().construct_mapping(node, deep)


def load_yaml(path: Path) -> Any:
    """Return the content of a YAML file.

    Raises:
        ConfigError: If the file cannot be read or is malformed; names the file and the line.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ConfigError(f"{path} does not exist") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path} is not a text file in UTF-8") from None
    except OSError as error:
        raise ConfigError(f"{path} cannot be read: {error.strerror}") from None
    try:
        return yaml.load(text, Loader=_StrictLoader)  # noqa: S506 - a SafeLoader
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f", line {mark.line + 1}" if mark else ""
        raise ConfigError(f"{path}{line}: malformed YAML: {error.problem}") from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{path}: malformed YAML: {error}") from None


def require_mapping(value: Any, where: str) -> dict[str, Any]:
    """Return `value` if it is a mapping with text keys.

    Raises:
        ConfigError: If it is anything else.
    """
    if not isinstance(value, dict):
        raise ConfigError(f"{where} is {describe(value)}; expected a mapping 'key: value'")
    for key in value:
        if not isinstance(key, str):
            raise ConfigError(f"{where}: the key {key!r} is {describe(key)}; expected a text")
    return value


def refuse_unknown(mapping: Mapping[str, Any], known: Iterable[str], where: str) -> None:
    """Check that every key is a known one.

    Raises:
        UnknownNameError: For the first unknown key; names the closest known ones.
    """
    known = set(known)
    for key in mapping:
        if key not in known:
            raise UnknownNameError("key", key, known, where)


def require_number(value: Any, where: str) -> float:
    """Return `value` as a float.

    Raises:
        ConfigError: If it is not a number.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"{where} is {describe(value)}; expected a number")
    return float(value)


def describe(value: Any) -> str:
    """Return what a YAML value is, for a message."""
    if value is None:
        return "empty"
    names = {bool: "a truth value", int: "an integer", float: "a number", str: "the text"}
    for kind, name in names.items():
        if type(value) is kind:
            return f"{name} {value!r}"
    return "a list" if isinstance(value, list) else "a mapping"

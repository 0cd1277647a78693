"""ROS 2 parameter files: sections by node name, in any nesting, and which node each is for.

The rules are those of rcl_yaml_param_parser: keys above `ros__parameters` are joined by slashes to
the name of a node, in which `*` stands for one part and `**` for any number; later sections win.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from swarm_common.files.resources import share_directory
from swarm_common.files.yaml_io import read_yaml
from swarm_common.model.errors import ConfigError, UnknownNameError

SECTION = "ros__parameters"
Flat = dict[str, Any]  # dotted parameter name -> value
REALISTIC: Flat = {"localisation.type": "amcl"}  # for navigators of robots with noisy sensors


def default_parameters() -> Flat:
    """Return the navigator's parameters with their defaults, from `params/navigator.yaml`."""
    path = share_directory() / "params" / "navigator.yaml"
    return read_parameter_file(path)["/**"]


def read_parameter_file(path: Path) -> dict[str, Flat]:
    """Return the parameters in a file by the names of nodes, in the order of the file.

    Returns:
        Parameters by dotted name; names of nodes begin with a slash and may have wildcards.
    """
    found: dict[str, Flat] = {}
    for pattern, body in _sections(read_yaml(path), "", path):
        known = found.setdefault(pattern, {})
        for name, value in flatten(body, f"{path}: {pattern}").items():
            if name in known:
                raise ConfigError(f"{path}: {pattern}: parameter '{name}' is given twice")
            known[name] = value
    return found


def is_for(pattern: str, node: str) -> bool:
    """Whether a section is for a node.

    Args:
        pattern: Name in the file, with or without a slash in front. One without any other slash,
            like `navigator`, means a node in any namespace, as Nav2's own files have it.
        node: Full name, like `/Srobot1/navigator`.
    """
    parts = pattern.removeprefix("/").split("/")
    if len(parts) == 1 and "*" not in pattern:
        return node.rpartition("/")[2] == parts[0]
    return re.fullmatch("".join(map(_form, parts)), node) is not None


def _form(part: str) -> str:
    if part == "**":
        return r"(/\w+)*"
    return "/" + (r"\w+" if part == "*" else re.escape(part).replace(r"\*", r"\w*"))


def _sections(
    tree: Mapping[str, Any], above: str, path: Path
) -> Iterator[tuple[str, Mapping[str, Any]]]:
    for key, body in tree.items():
        if key == SECTION:
            continue
        name = f"{above}/{key.removeprefix('/') if not above else key}"
        where = f"{path}: {name}"
        if not isinstance(body, dict) and SECTION in tree:
            raise UnknownNameError("key", key, [SECTION], f"{path}: {above}")
        if not isinstance(body, dict) or not body or not key:
            raise ConfigError(f"{where}: expected a section '{SECTION}:' with parameters")
        if SECTION in body:
            if not isinstance(body[SECTION], dict):
                raise ConfigError(f"{where}: expected parameters in the section '{SECTION}:'")
            yield name, body[SECTION]
        yield from _sections(body, name, path)
    if SECTION in tree and not above:
        raise ConfigError(f"{path}: '{SECTION}' stands below no node; write '/**:' above it")


def flatten(tree: Mapping[str, Any], where: str = "", prefix: str = "") -> Flat:
    """Return nested parameters under their dotted names."""
    flat: Flat = {}
    for key, value in tree.items():
        name = f"{prefix}{key}"
        branch = isinstance(value, Mapping) and len(value) > 0
        for leaf, item in (flatten(value, where, f"{name}.") if branch else {name: value}).items():
            if leaf in flat:
                raise ConfigError(f"{where}: parameter '{leaf}' is given twice")
            flat[leaf] = item
    return flat


def nest(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Return dotted parameters as the nested mapping of a parameter file."""
    tree: dict[str, Any] = {}
    for name, value in flat.items():
        *groups, key = name.split(".")
        node = tree
        for group in groups:
            node = node.setdefault(group, {})
        node[key] = value
    return tree


def typed(name: str, value: Any, known: Mapping[str, Any], where: str) -> Any:
    """Return a parameter's value, an integer as float where the default is one.

    Args:
        known: Default of each parameter by dotted name; gives the type too.
        where: Section of the file, for the message.

    Raises:
        ConfigError: If the name is unknown or the type is not that of the default.
    """
    if name not in known:
        raise UnknownNameError("parameter", name, known, where)
    expected = type(known[name])
    if expected is float and type(value) is int:
        return float(value)
    if type(value) is not expected:
        raise ConfigError(
            f"{where}: parameter '{name}' is {value!r} ({type(value).__name__});"
            f" expected a {expected.__name__} like {known[name]!r}"
        )
    return value

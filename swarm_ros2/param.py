"""`ros2 param`: list, get, set, dump, load, describe, delete."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import get_parameter_value, parameter_value_to_python

from swarm_common.files.params_io import is_for, read_parameter_file
from swarm_common.model.errors import SwarmError, UnknownNameError
from swarm_ros2 import graph
from swarm_ros2.verbs import NODE, add_flag, add_verb

LABELS = {
    ParameterType.PARAMETER_BOOL: "Boolean value is:",
    ParameterType.PARAMETER_INTEGER: "Integer value is:",
    ParameterType.PARAMETER_DOUBLE: "Double value is:",
    ParameterType.PARAMETER_STRING: "String value is:",
    ParameterType.PARAMETER_BYTE_ARRAY: "Byte values are:",
    ParameterType.PARAMETER_BOOL_ARRAY: "Boolean values are:",
    ParameterType.PARAMETER_INTEGER_ARRAY: "Integer values are:",
    ParameterType.PARAMETER_DOUBLE_ARRAY: "Double values are:",
    ParameterType.PARAMETER_STRING_ARRAY: "String values are:",
}
TYPES = (
    "not set", "boolean", "integer", "double", "string", "byte array", "boolean array",
    "integer array", "double array", "string array",
)  # fmt: skip
ANSWER = 6.0  # [s] that a node has for an answer
ASK_PERIOD = 2.0  # [s] after which it is asked again


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 param`."""
    name = "Name of the parameter"
    add_verb(verbs, "delete", "Delete parameter", _delete, node_name=NODE, parameter_name=name)
    what = "Show descriptive information about declared parameters"
    verb = add_verb(verbs, "describe", what, _describe, node_name=NODE)
    verb.add_argument("parameter_names", nargs="+", help="Names of the parameters")
    verb = add_verb(verbs, "load", "Load parameter file for a node", _load, node_name=NODE)
    verb.add_argument("parameter_file", type=Path, help="Parameter file")
    wildcard = "Do not load parameters in the '/**' namespace into the node"
    add_flag(verb, "--no-use-wildcard", help=wildcard)
    what = "Show all parameters of a node in a YAML file format"
    add_verb(verbs, "dump", what, _dump, node_name=NODE)
    verb = add_verb(verbs, "get", "Get parameter", _get, node_name=NODE, parameter_name=name)
    add_flag(verb, "--hide-type", help="Hide the type information")
    verb = add_verb(verbs, "list", "Output a list of available parameters", _list)
    verb.add_argument("node_name", nargs="?", help=NODE)
    prefixes = "Only list parameters with the provided prefixes"
    verb.add_argument("--param-prefixes", nargs="+", default=[], help=prefixes)
    add_flag(verb, "--param-type", help="Print parameter types with parameter names")
    verb = add_verb(verbs, "set", "Set parameter", _set, node_name=NODE, parameter_name=name)
    verb.add_argument("value", help="Value of the parameter")


def call(node: Node, owner: str, kind: Any, service: str, request: Any) -> Any:
    """Return the answer of a node's service, whose server may wait for a client to appear."""
    client = node.create_client(kind, f"{owner}/{service}")
    if not graph.wait_for(client.service_is_ready):
        raise SwarmError(f"{owner} offers no service {service}")
    is_late = graph.deadline(ANSWER)
    while not is_late():
        future = client.call_async(request)
        _spin_for(node, future)
        if future.done():
            node.destroy_client(client)
            return future.result()
    raise SwarmError(f"{owner} did not answer within {ANSWER:g} s")


def _spin_for(node: Node, future: Any) -> None:
    """Wait for an answer for `ASK_PERIOD`: discovery may have lost it, and all may be repeated."""
    is_overdue = graph.deadline(ASK_PERIOD)
    graph.spin(node, lambda: future.done() or is_overdue())


def _names(node: Node, owner: str, prefixes: Sequence[str] = ()) -> list[str]:
    request = ListParameters.Request(prefixes=list(prefixes))
    answer = call(node, owner, ListParameters, "list_parameters", request)
    return sorted(answer.result.names)


def _values(node: Node, owner: str, names: list[str]) -> list[Any]:
    request = GetParameters.Request(names=names)
    return list(call(node, owner, GetParameters, "get_parameters", request).values)


def _list(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        if options.node_name is not None:
            _print_list(node, graph.require_node(node, options.node_name), options)
            return
        graph.settle(node)
        services = dict(node.get_service_names_and_types())
        for owner in graph.node_names(node):
            if f"{owner}/list_parameters" in services:
                print(f"{owner}:")
                _print_list(node, owner, options)


def _print_list(node: Node, owner: str, options: argparse.Namespace) -> None:
    names = _names(node, owner, options.param_prefixes)
    kinds = [""] * len(names)
    if options.param_type:
        request = DescribeParameters.Request(names=names)
        answer = call(node, owner, DescribeParameters, "describe_parameters", request)
        kinds = [f" (type: {TYPES[found.type]})" for found in answer.descriptors]
    for name, kind in zip(names, kinds, strict=True):
        print(f"  {name}{kind}")


def _get(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        owner = graph.require_node(node, options.node_name)
        values = _values(node, owner, [options.parameter_name])
    if not values or values[0].type == ParameterType.PARAMETER_NOT_SET:
        raise SwarmError("Parameter not set.")
    value = parameter_value_to_python(values[0])
    print(value if options.hide_type else f"{LABELS[values[0].type]} {_plain(value)}")


def _set(options: argparse.Namespace) -> None:
    value = get_parameter_value(options.value)
    with graph.open_node() as node:
        owner = graph.require_node(node, options.node_name)
        result = _send(node, owner, {options.parameter_name: value})[0]
        if not result.successful:
            reason = _why_not_set(node, owner, options, value, result.reason)
            raise SwarmError(f"Setting parameter failed{reason and f': {reason}'}")
    print(f"Set parameter successful{result.reason and f': {result.reason}'}")


def _send(node: Node, owner: str, values: dict[str, Any]) -> list[Any]:
    parameters = [Parameter(name=name, value=value) for name, value in values.items()]
    request = SetParameters.Request(parameters=parameters)
    return list(call(node, owner, SetParameters, "set_parameters", request).results)


def _why_not_set(
    node: Node, owner: str, options: argparse.Namespace, value: Any, reason: str
) -> str:
    """Return why a parameter was not set; rclpy's own answer names none that does not exist."""
    name = options.parameter_name
    if "undeclared parameter" in reason:
        return str(UnknownNameError("parameter", name, _names(node, owner), owner))
    if value.type == ParameterType.PARAMETER_INTEGER and "DOUBLE" in reason:
        return f"{name} is a double; write {options.value}.0"
    return reason


def _delete(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        owner = graph.require_node(node, options.node_name)
        result = _send(node, owner, {options.parameter_name: ParameterValue()})[0]
    reason = f": {result.reason}" if result.reason else ""
    if result.successful:
        print(f"Deleted parameter successfully{reason}")
    else:
        print(f"Deleting parameter failed{reason}", file=sys.stderr)


def _describe(options: argparse.Namespace) -> None:
    request = DescribeParameters.Request(names=options.parameter_names)
    with graph.open_node() as node:
        owner = graph.require_node(node, options.node_name)
        answer = call(node, owner, DescribeParameters, "describe_parameters", request)
        known = answer.descriptors or _names(node, owner)
    if not answer.descriptors:  # rclpy describes all of them or none
        missing = next((n for n in options.parameter_names if n not in known), "")
        raise UnknownNameError("parameter", missing, known, owner)
    for found in answer.descriptors:
        print(f"Parameter name: {found.name}\n  Type: {TYPES[found.type]}")
        if found.description:
            print(f"  Description: {found.description}")
        print("  Constraints:")
        if found.read_only:
            print("    Read only: true")
        for limits in [*found.floating_point_range, *found.integer_range][:1]:
            print(f"    Min value: {limits.from_value}\n    Max value: {limits.to_value}")
            if limits.step:
                print(f"    Step: {limits.step}")
        if found.additional_constraints:
            print(f"    Additional constraints: {found.additional_constraints}")


def _load(options: argparse.Namespace) -> None:
    sections = read_parameter_file(options.parameter_file)
    with graph.open_node() as node:
        owner = graph.require_node(node, options.node_name)
        values: dict[str, Any] = {}
        for pattern, given in sections.items():
            if is_for(pattern, owner) and not (options.no_use_wildcard and "*" in pattern):
                values |= given
        if not values:
            raise SwarmError(f"Param file does not contain any valid parameters for {owner}")
        sent = {name: get_parameter_value(_text(value)) for name, value in values.items()}
        results = _send(node, owner, sent)
    for name, result in zip(values, results, strict=True):
        reason = f": {result.reason}" if result.reason else ""
        if result.successful:
            print(f"Set parameter {name} successful{reason}")
        else:
            print(f"Set parameter {name} failed{reason}", file=sys.stderr)


def _text(value: Any) -> str:
    """Return a value as YAML in one line, a text in quotes."""
    return str(yaml.safe_dump(value, default_flow_style=True, width=sys.maxsize)).partition("\n")[0]


def _dump(options: argparse.Namespace) -> None:
    with graph.open_node() as node:
        owner = graph.require_node(node, options.node_name)
        names = _names(node, owner)
        values = [_plain(parameter_value_to_python(v)) for v in _values(node, owner, names)]
    tree: dict[str, Any] = {}
    for name, value in zip(names, values, strict=True):
        branch = tree
        *parents, leaf = name.split(".")
        for parent in parents:
            branch = branch.setdefault(parent, {})
        branch[leaf] = value
    print(yaml.safe_dump({owner: {"ros__parameters": tree}}, sort_keys=False), end="")


def _plain(value: Any) -> Any:
    return list(value) if hasattr(value, "typecode") else value

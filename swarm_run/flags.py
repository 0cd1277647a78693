"""The command line of `swarm-up`: the flags of `RunSpec`, and what it does in place of a run."""

from __future__ import annotations

import functools
import inspect
from dataclasses import dataclass, fields
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import msgspec
import typer
import yaml

from swarm_common.files.convert import read
from swarm_describe.robots.source import robot_names as robot_models
from swarm_run.listing import listing
from swarm_run.spec import OUTPUT_PANEL, SWARM_PANEL, File, RunSpec


def _list(wanted: bool) -> None:
    if wanted:
        typer.echo(listing())
        raise typer.Exit()


@dataclass(frozen=True, slots=True, kw_only=True)
class Actions:
    """Work of `swarm-up` in place of a run, or with several."""

    list_: Annotated[
        bool,
        typer.Option(
            "--list",
            help="List the worlds, missions, robots and fleets to choose from, and exit.",
            is_eager=True,
            callback=_list,
        ),
    ] = False
    spec: Annotated[
        Path | None, typer.Option(help="File (.yaml) with options by name; flags beside it win.")
    ] = None
    print_spec: Annotated[
        bool, typer.Option("--print-spec", help="Print what --spec would need to know, and exit.")
    ] = False
    describe: Annotated[
        str | None,
        typer.Option(
            rich_help_panel=SWARM_PANEL,
            autocompletion=robot_models,
            help="Show what is known of a robot model, and where each value is from; then exit.",
            metavar="ROBOT",
            show_default=False,
        ),
    ] = None
    sweep: Annotated[
        list[str] | None,
        typer.Option(
            rich_help_panel=OUTPUT_PANEL,
            help="Runs for each value of an option or parameter: robots=4,8,12; with a page.",
            show_default=False,
        ),
    ] = None
    warm_up: Annotated[
        float | None,
        typer.Option(
            rich_help_panel=OUTPUT_PANEL,
            show_default="a sixth of --duration",
            help="Time [s] that a sweep leaves out.",
        ),
    ] = None


@functools.cache
def _flags() -> dict[str, inspect.Parameter]:
    """Return the parameter of each flag by name, as typer reads it."""
    hints = get_type_hints(Actions, include_extras=True)
    flags = {item.name: (hints[item.name], item.default) for item in fields(Actions)}
    hints = get_type_hints(RunSpec, include_extras=True)
    for field in msgspec.structs.fields(RunSpec):
        if get_origin(hints[field.name]) is Annotated:
            default = None if field.default == () else field.default
            flags[field.name] = _typed_as(hints[field.name]), default
    return {
        name: inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind
        )
        for name, (kind, default) in flags.items()
    }


def _typed_as(hint: Any) -> Any:
    """Return the annotation of a field for typer, which knows no union and no range."""
    kind, *_, option = get_args(hint)
    kinds = get_args(kind) if NoneType in get_args(kind) else (kind,)
    first = kinds[0]
    if get_origin(first) is tuple:
        return Annotated[list[Path] | None, option]
    if get_origin(first) is Annotated:
        first = Path if first == File else get_args(first)[0]
    return Annotated[first | None if NoneType in kinds else first, option]


def signature() -> inspect.Signature:
    """Return the signature from which typer makes the flags."""
    context = inspect.Parameter(
        "context", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=typer.Context
    )
    return inspect.Signature([context, *_flags().values()])


@functools.cache
def parser() -> Any:
    """Return the command line of `swarm-up` that runs nothing."""

    def ignore(context: typer.Context, **_: Any) -> None: ...

    ignore.__signature__ = signature()  # type: ignore[attr-defined]
    app = typer.Typer()
    app.command()(ignore)
    return typer.main.get_command(app)


def actions_of(context: Any) -> Actions:
    """Return what a command line asks for beside a run."""
    return Actions(**{item.name: context.params[item.name] for item in fields(Actions)})


def stated_of(context: Any) -> dict[str, Any]:
    """Return the fields of the run that a command line states: by flags, else by --spec.

    Raises:
        ConfigError: If the file of --spec is unusable.
    """
    stated: dict[str, Any] = {}
    if (path := context.params["spec"]) is not None:
        spec = read(path, RunSpec, may_be_empty=True)
        stated = {name: getattr(spec, name) for name in msgspec.to_builtins(spec)}
    for name in RunSpec.__struct_fields__:
        if getattr(context.get_parameter_source(name), "name", "") == "COMMANDLINE":
            stated[name] = _plain(context.params[name])
    return stated


def _plain(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(map(str, value))
    return str(value) if isinstance(value, Path) else value


def text_of(spec: RunSpec) -> str:
    """Return the text of a file for --spec: all that is not the default."""
    return yaml.safe_dump(msgspec.to_builtins(spec), sort_keys=False)

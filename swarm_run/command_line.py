"""A command as a process: what it needs before its imports, and how it ends.

Any mistake in a command line is one message on stderr and exit code 2.
"""

from __future__ import annotations

import os
import signal
import sys
from typing import TYPE_CHECKING

# All other modules are imported later, when Ctrl-C no longer ends in a traceback.
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, NoReturn

    import typer

OK, MISSED, BAD_INPUT, COMPONENT_FAILED = range(4)  # exit codes
CTRL_C = 128 + signal.SIGINT
LONGEST_NAME = 200  # letters of a file's name that are shown
SWARM_UP = (sys.executable, "-c", "from swarm_commander.cli.main import swarm_up; swarm_up()")


def run_command(name: str, load: Callable[[], typer.Typer]) -> NoReturn:
    """Run a command line as this process, and end it."""
    _end_quietly()
    from swarm_common.process import start

    start.prepare()
    try:
        code = run_app(name, load)
    except Exception as error:
        import traceback

        traceback.print_exc()
        sys.stderr.write(_hint_of_hidden_modules(error))
        code = 3  # a fault of ours must not look like a missed goal
    _end_quietly()  # while the interpreter ends
    sys.exit(code)


def _end_quietly() -> None:
    """Let SIGINT and SIGTERM end this process without a traceback; shells see 130 and 143."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def prepare_ros() -> None:
    """Set the environment and build the interfaces, before rclpy and messages are imported."""
    from swarm_common.middleware import ros_env
    from swarm_setup.build import ensure_interfaces

    ros_env.set_defaults()
    ensure_interfaces()


def run_app(name: str, load: Callable[[], typer.Typer]) -> int:
    """Run a command line; any mistake in it becomes one message on stderr and exit code 2.

    SIGINT and SIGTERM end it without a traceback and with 128 + their number, once its modules
    are imported; before and after, `run_command` sees to them.
    """
    from swarm_common.process import standard_streams

    standard_streams.open_standard_streams()
    try:
        code = _run_app(name, load)
    except OSError as error:
        code = standard_streams.end_of_output(name, error)
    return standard_streams.finish_output(name, code)


def _run_app(name: str, load: Callable[[], typer.Typer]) -> int:
    install_signal_handlers()
    if sys.argv[1:] == ["--version"]:
        from importlib import metadata

        sys.stdout.write(f"{name} {metadata.version('swarm-workbench')}\n")
        return 0
    import traceback

    from swarm_common.middleware.other_ros import set_aside

    set_aside(name)
    import typer

    from swarm_common.model.errors import SwarmEndedError, SwarmError
    from swarm_common.process.standard_streams import FULL, READER_LEFT, complain, is_of_output

    # Some versions of typer bring a click of their own, so the base is reached through typer.
    usage_error: type[Exception] = typer.BadParameter.__bases__[0]
    ended_by: list[int] = []

    def end(number: int, _: object) -> None:
        ended_by.append(number)
        raise KeyboardInterrupt

    try:
        check_surroundings()
        app = load()
        signal.signal(signal.SIGINT, end)
        signal.signal(signal.SIGTERM, end)
        command: Any = typer.main.get_command(app)
        command.params.append(_version_option())
        command.context_settings["help_option_names"] = ["--help", "-h"]
        code = command(prog_name=name, standalone_mode=False)
    except usage_error as error:
        message = _usage_message(error, command)
    except SwarmEndedError as error:  # a component failed, from where the command stands
        complain(f"{name}: {error}")
        return COMPONENT_FAILED
    except SwarmError as error:
        message = str(error)
    except (typer.Abort, KeyboardInterrupt) as stop:
        if isinstance(stop.__cause__, EOFError) and not ended_by:  # typer takes it for Ctrl-D
            traceback.print_exc()
            return COMPONENT_FAILED
        return 128 + (ended_by[0] if ended_by else signal.SIGINT)
    except SystemExit as end_:
        if isinstance(end_.__context__, BrokenPipeError):  # rich's 1 is that of a missed goal
            return READER_LEFT
        raise
    except OSError as error:  # of a file that the user names: too long a name, no permission, ...
        if is_of_output(error):
            raise
        if error.errno not in FULL and error.filename is None:
            traceback.print_exc()
            return COMPONENT_FAILED
        message = f"cannot use {_shown(error.filename)}: {error.strerror}"
        if error.errno in FULL:
            complain(f"{name}: {message}")
            return COMPONENT_FAILED
    except Exception as error:  # a fault of ours must not look like a missed goal
        if ended_by or type(error).__name__ == "ExternalShutdownException":  # rclpy's, of a signal
            return 128 + (ended_by[0] if ended_by else signal.SIGTERM)
        traceback.print_exc()
        sys.stderr.write(_hint_of_hidden_modules(error))
        return COMPONENT_FAILED
    else:
        if ended_by and code == CTRL_C:  # what newer versions of typer make of KeyboardInterrupt
            return 128 + ended_by[0]
        return code if isinstance(code, int) else 0
    complain(f"{name}: {message}")
    return BAD_INPUT


def install_signal_handlers() -> None:
    """Undo what whoever started us has set of signals; a process inherits that.

    Where SIGCHLD is ignored, every process seems to end with exit code 0.
    """
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())


def check_surroundings() -> None:
    """Refuse what no command can work in; find places for what is kept between runs.

    Raises:
        ConfigError: If the current folder was deleted, numba must not compile, or nothing can be
            written anywhere.
    """
    from swarm_common.model.errors import ConfigError
    from swarm_common.process import home

    try:
        os.getcwd()
    except OSError as error:
        raise ConfigError(
            f"the current folder cannot be used: {error.strerror}; cd to another"
        ) from None
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        raise ConfigError("NUMBA_DISABLE_JIT is set, and the kernels need the compiler: unset it")
    home.set_defaults(os.environ)


def _hint_of_hidden_modules(error: Exception) -> str:
    """Return a line on a file of PYTHONPATH that has the name of a module which we need."""
    from importlib.machinery import PathFinder
    from pathlib import Path

    folders = {
        Path(each).absolute() for each in os.environ.get("PYTHONPATH", "").split(":") if each
    }
    files = [getattr(module, "__file__", None) or "" for module in list(sys.modules.values())]
    trace = error.__traceback__
    while trace is not None:
        files.append(trace.tb_frame.f_code.co_filename)
        trace = trace.tb_next
    others = [each for each in sys.path if Path(each or ".").absolute() not in folders]
    for path in (Path(file).absolute() for file in files if file.endswith(".py")):
        if path.parent in folders and PathFinder.find_spec(path.stem, others) is not None:
            return (
                f"{path}, on PYTHONPATH, hides the {path.stem} that is needed: unset PYTHONPATH\n"
            )
    return ""


def _version_option() -> Any:
    """Return the option `--version` for the help text; `run_app` answers it."""
    import typer

    app = typer.Typer(add_completion=False)
    described = typer.Option(False, "--version", help="Show the version and exit.")

    @app.command()
    def show(version: bool = described) -> None:
        pass

    command: Any = typer.main.get_command(app)
    (option,) = command.params
    option.expose_value = option.required = False
    option.default = False
    return option


def _usage_message(error: Exception, command: Any) -> str:
    """Return the message of a usage error, with the value that was found."""
    message = str(error.format_message())  # type: ignore[attr-defined]
    message += _hint(error, command)
    details = getattr(error.__cause__, "errors", None)  # pydantic's, behind newer versions of typer
    found = details()[0].get("input") if details is not None else None
    message = message.replace("Value error, ", "")
    is_named = found is None or f"'{found}'" in message
    return message if is_named else f"{message} (found '{found}')"


def _hint(error: Exception, command: Any) -> str:
    """Return what the option that a usage error is about takes, or with two dashes would be."""
    name = getattr(error, "option_name", None)
    commands = [command, *getattr(command, "commands", {}).values()]
    parameters = [item for one in commands for item in one.params]
    helps = {word: getattr(item, "help", "") for item in parameters for word in item.opts}
    if helps.get(name) and "argument" in str(error):
        return f" {name}: {helps[name]}"
    meant = [f"-{word}" for word in sys.argv[1:] if f"-{word}" in helps and word[:2] != "--"]
    return f"; did you mean {meant[0]}?" if meant and name not in helps else ""


def _shown(name: object) -> str:
    """Return the name of a file in letters that can be printed, and not too many."""
    text = os.fsencode(str(name)).decode(errors="replace")
    return text if len(text) <= LONGEST_NAME else f"{text[:LONGEST_NAME]}..."

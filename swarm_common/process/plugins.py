"""Plug-ins: parts of a robot that users bring, found by name and kept from harming anybody else."""

from __future__ import annotations

import contextlib
import enum
import functools
import importlib
import inspect
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.metadata import entry_points
from pathlib import Path
from types import FrameType
from typing import Any

from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError

GROUPS = "swarm_workbench."  # of entry points, before controllers, planners and so on
MOST_TIME = 1.0  # [s] of wall time that a call may take
MOST_START_TIME = 60.0  # [s] that its construction may take
LEAST_SHARE = 0.1  # of the processor, from which on a call computes and does not sleep
MOST_DELAYED = 10  # times as long as allowed, at most, on a busy machine
COMPILERS = ("numba.core.", "llvmlite.")

_printed: set[str] = set()  # plug-ins of this process that have failed


class PluginFault(enum.Enum):
    """Kind of failure of a plug-in."""

    RAISED = "raised"
    LATE = "late"
    UNUSABLE = "unusable"  # what it returned


class PluginError(SwarmError):
    """A plug-in failed while the robot drives.

    Attributes:
        fault: Kind of the failure.
    """

    def __init__(self, fault: PluginFault, message: str) -> None:
        """Keep how it failed.

        Args:
            message: With the name of the plug-in.
        """
        self.fault = fault
        super().__init__(message)


def load_plugin(
    group: str, name: str, built_in: Mapping[str, str], parameter: str
) -> Callable[..., Any]:
    """Return the class or function that a parameter names; the working directory is searched too.

    Args:
        group: Group of entry points, like `controllers`.
        name: `module:Class`, a built-in name, that of an entry point of an installed package, or a
            file with a built-in suffix.
        built_in: `module:Class` of the built-in ones by name, and by suffix like `.onnx`.
        parameter: Whose value the name is, for messages.

    Raises:
        ConfigError: If there is none of this name, or its module cannot be imported.
    """
    target = built_in.get(name, name)
    if (suffix := Path(name).suffix) in built_in:
        if not Path(name).is_file():
            raise ConfigError(f"{parameter} is '{name}': there is no such file in {os.getcwd()}")
        target = built_in[suffix]
    if ":" not in target:
        found = {point.name: point.value for point in entry_points(group=GROUPS + group)}
        if target not in found:
            known = [*built_in, *found]
            raise UnknownNameError(parameter, name, [*known, "module:Class"])
        target = found[target]
    module_name, _, path = target.partition(":")
    owner = _module(module_name, f"{parameter} is '{name}'")
    made: Any = owner
    for part in path.split("."):
        if not hasattr(made, part):
            members = inspect.getmembers(owner, inspect.isclass)
            classes = [key for key, found in members if found.__module__ == module_name]
            raise UnknownNameError(parameter, path, classes, module_name)
        made = getattr(made, part)
    if not callable(made):
        raise ConfigError(f"{parameter} is '{name}', which is no class or function")
    return made  # type: ignore[no-any-return]


def _module(name: str, what: str) -> Any:
    here = os.getcwd()
    if here not in sys.path and "" not in sys.path:
        sys.path.append(here)  # for good: it may import more of its kind later
        importlib.invalidate_caches()
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as cause:
        if cause.name is not None and f"{name}.".startswith(f"{cause.name}."):
            raise ConfigError(
                f"{what}: there is no module '{cause.name}' in {here} or among installed packages"
            ) from cause
        raise ConfigError(f"{what}: its module needs '{cause.name}', which is missing") from cause
    except Exception as cause:
        raise ConfigError(f"{what}: its module does not load: {_told(cause)}") from cause


class Guard:
    """Makes and calls one plug-in. A fault is a `PluginError`; the first is printed as well.

    One that was late, or could not be made, is not called again.

    Attributes:
        what: Kind and name, for messages.
    """

    def __init__(self, what: str, make: Callable[..., Any], *arguments: Any) -> None:
        """Make the plug-in.

        Args:
            what: Kind and name, for messages.
        """
        self.what = what
        self._own: Any = None
        self._final: PluginError | None = None
        try:
            self._own = self._run("__init__", make, arguments, MOST_START_TIME)
        except PluginError as error:
            self._final = error

    def has(self, method: str) -> bool:
        """Whether the plug-in has an optional member."""
        return hasattr(self._own, method)

    def value(self, name: str) -> Any:
        """Return an attribute, or what a property works out.

        Raises:
            PluginError: If that raises or takes too long.
        """
        return self._run(name, getattr, (self._own, name), MOST_TIME)

    def call(
        self,
        method: str,
        *arguments: Any,
        passes: tuple[type[Exception], ...] = (),
        **keywords: Any,
    ) -> Any:
        """Return the result of a method of the plug-in.

        Args:
            passes: Exceptions that are an answer, and no fault.

        Raises:
            PluginError: If it raises another one, or takes longer than `MOST_TIME`.
        """
        if self._final is not None:
            raise self._final
        function = functools.partial(getattr(self._own, method, _no_method), **keywords)
        return self._run(method, function, arguments, MOST_TIME, passes)

    def unusable(self, problem: str) -> PluginError:
        """Return the error that what the plug-in returned is of no use.

        Args:
            problem: Value that was returned, and value that was expected.
        """
        return self._noted(PluginFault.UNUSABLE, problem)

    def _run(
        self,
        method: str,
        function: Any,
        arguments: Sequence[Any],
        most: float,
        passes: tuple[type[Exception], ...] = (),
    ) -> Any:
        try:
            with _alarm(most):
                return function(*arguments)
        except _LateError:
            pass
        except passes:
            raise
        except Exception as error:
            problem = f"{method} raised {_told(error)}"
            raise self._noted(PluginFault.RAISED, problem, error) from error
        problem = f"{method} took longer than {most:g} s, and it is not called again"
        self._final = self._noted(PluginFault.LATE, problem)
        raise self._final

    def _noted(
        self, fault: PluginFault, problem: str, error: Exception | None = None
    ) -> PluginError:
        message = f"{self.what}: {problem}"
        if self.what not in _printed:
            _printed.add(self.what)
            with contextlib.suppress(OSError):  # the disk of the log is full
                if error is not None:
                    traceback.print_exception(error)
                sys.stderr.write(f"{message}\n")
                sys.stderr.flush()
        return PluginError(fault, message)


class _LateError(BaseException):
    """Ends a call that takes too long; no `except Exception` of a plug-in catches it."""


@contextlib.contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    """Raise `_LateError` in the block, or at its end, if it takes too long.

    Time in which numba compiles does not count. On a busy machine, what computes all the time has
    that much time of the processor. A call beside the main thread is not interrupted.
    """
    started, used_before = time.monotonic(), time.thread_time()
    if threading.current_thread() is not threading.main_thread():
        yield
        if time.monotonic() - started > seconds:
            raise _LateError
        return
    is_armed = True

    def ring(number: int, frame: FrameType | None) -> None:
        rest = seconds
        if is_armed and not _compiles(frame):
            used, passed = time.thread_time() - used_before, time.monotonic() - started
            rest = seconds - used
            if used < LEAST_SHARE * passed or rest <= 0.0 or passed > MOST_DELAYED * seconds:
                raise _LateError
        signal.setitimer(signal.ITIMER_REAL, rest)

    handler = signal.signal(signal.SIGALRM, ring)
    rest, interval = signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        is_armed = False
        passed = time.monotonic() - started
        signal.setitimer(signal.ITIMER_REAL, max(rest - passed, 1e-3) if rest else 0.0, interval)
        signal.signal(signal.SIGALRM, handler)


def _compiles(frame: FrameType | None) -> bool:
    while frame is not None:
        if str(frame.f_globals.get("__name__")).startswith(COMPILERS):
            return True
        frame = frame.f_back
    return False


def _no_method(*arguments: Any) -> None:
    raise TypeError("there is no such method")


def _told(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__

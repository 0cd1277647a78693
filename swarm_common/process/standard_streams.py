"""stdin, stdout and stderr, whatever those that started us made of them: closed, full, gone."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import select
import signal
import sys
import traceback
from collections import Counter
from typing import TextIO

LONGEST_MESSAGE = 600  # letters; a message may quote an input of any length
MOST_KINDS = 100  # of which the traceback is printed
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EIO)  # not the user's input
CANNOT_WRITE = 3  # exit code: not the user's input, and not a result either
READER_LEFT = 128 + signal.SIGPIPE  # exit code, that of a program which the signal ends


def open_standard_streams() -> None:
    """Open /dev/null for each of stdin, stdout and stderr that whoever started us has closed.

    Else the next file or pipe gets its number, and prints land there.
    """
    number = os.open(os.devnull, os.O_RDWR)
    while number <= 2:
        number = os.dup(number)
    os.close(number)
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))
    for stream in (sys.stdout, sys.stderr):  # what the terminal cannot show becomes a "?"
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def finish_output(name: str, code: int, failed: int = CANNOT_WRITE) -> int:
    """Write what is still in the buffers of stdout and stderr, before the interpreter would.

    Args:
        failed: Exit code of a command that did well, but whose output cannot be written.
    """
    failure = _flush(sys.stdout)
    if failure is not None and code == 0:
        code = end_of_output(name, failure, failed)
    _flush(sys.stderr)
    return code


def end_of_output(name: str, error: OSError, failed: int = CANNOT_WRITE) -> int:
    """Report that the output cannot be written, unless its reader (`head`, `less`) has seen enough.

    Args:
        failed: Exit code if it is not the reader who left.
    """
    _forget(sys.stdout)
    if error.errno == errno.EPIPE:
        return READER_LEFT
    complain(f"{name}: cannot write the output: {error.strerror}")
    return failed


def complain(message: str) -> None:
    """Report on stderr why a command ends; that nobody can read it changes no exit code.

    Args:
        message: Without a newline; what a terminal would obey is shown as text.
    """
    with contextlib.suppress(OSError):
        sys.stderr.write(f"{printable(message)}\n")


def is_of_output(error: OSError) -> bool:
    """True if an error is that stdout cannot be written, or that the disk of a file is full.

    Args:
        error: Error of a write; one that names a file is not of the output.
    """
    return error.filename is None and (error.errno in FULL or _has_no_reader())


def _has_no_reader() -> bool:
    poll = select.poll()
    with contextlib.suppress(OSError, ValueError):
        poll.register(sys.stdout.fileno(), 0)
        return any(event & (select.POLLERR | select.POLLHUP) for _, event in poll.poll(0))
    return False


def _flush(stream: TextIO) -> OSError | None:
    try:
        stream.flush()
    except OSError as error:
        _forget(stream)
        return error
    except ValueError:  # it was closed
        pass
    return None


def _forget(stream: TextIO) -> None:
    """Redirect a stream to /dev/null, so that its buffered text causes no error later."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


class FaultLog:
    """Prints the traceback of each kind of fault once, to the log of the process.

    Attributes:
        counts: Faults by kind and place.
    """

    def __init__(self, what: str) -> None:
        """Start without any.

        Args:
            what: Is dropped by a fault, like `message`; for the log.
        """
        self._what = what
        self.counts: Counter[str] = Counter()

    def note(self, error: Exception) -> str:
        """Count a fault, and print the traceback of the first of its kind.

        Returns:
            A message for the client that caused it.
        """
        frame = traceback.extract_tb(error.__traceback__)[-1]
        key = f"{type(error).__name__} in {frame.name}, line {frame.lineno}"
        self.counts[key] += 1
        if self.counts[key] == 1 and len(self.counts) <= MOST_KINDS:
            with contextlib.suppress(OSError):  # the disk of the log is full
                sys.stderr.write(f"a {self._what} was dropped by a fault of ours: {key}\n")
                traceback.print_exception(error)
                sys.stderr.flush()
        return shown(f"fault, {key}: {error}")


def shown(message: str) -> str:
    """Return a message without control characters, and not longer than anybody reads."""
    text = printable(message[: 2 * LONGEST_MESSAGE])
    if len(message) <= LONGEST_MESSAGE:
        return text
    half = LONGEST_MESSAGE // 2
    return f"{text[:half]} ... {shown(message[-half:])}"


def printable(message: str) -> str:
    """Return a message without control characters: it may quote an input of any letters."""
    return "".join(letter if letter.isprintable() or letter == "\n" else "?" for letter in message)

"""Reads models in a process beside the world, which goes on meanwhile."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import socket
import subprocess
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

from swarm_common.process import start
from swarm_sim.world.model_reader import HEADER, Model, ModelRequest
from swarm_sim.world.request_checks import Reason, RefusedError

LIMIT = 30.0  # [s] of wall time for a model, the start of the reader included
IDLE = 60.0  # [s] of wall time after which a reader that nobody needs ends
MOST_WAITING = 20  # requests
LONGEST_ANSWER = 100_000_000  # [bytes]
CHUNK = 1 << 16  # [bytes]


@dataclass(slots=True)
class _Job:
    ticket: Any
    unsent: bytes
    answer: bytearray = field(default_factory=bytearray)
    deadline: float = 0.0


class ModelLoader:
    """Receives requests, and returns models when they are there. It never waits.

    The reader is started at the first request. It is started by exec, not by fork alone, since this
    process has threads of DDS and numba.
    """

    def __init__(self, limit: float = LIMIT) -> None:
        """Begin without a reader."""
        self._limit = limit
        self._jobs: deque[_Job] = deque()
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: socket.socket | None = None
        self._idle_since = 0.0

    @property
    def has_room(self) -> bool:
        """Whether another request is taken now."""
        return len(self._jobs) < MOST_WAITING

    def ask(self, ticket: Any, request: ModelRequest) -> None:
        """Ask for a model; `poll` returns the ticket with it."""
        if not self.has_room:
            raise RefusedError(
                Reason.FAILED, f"{MOST_WAITING} models are being read; ask again later"
            )
        data = pickle.dumps(request)
        self._jobs.append(_Job(ticket, HEADER.pack(len(data)) + data))

    def poll(self) -> list[tuple[Any, Model | RefusedError]]:
        """Return the models, or failures, since the last call, in the order of the requests."""
        if not self._jobs:
            if self._process is not None and time.monotonic() > self._idle_since + IDLE:
                self.close()
            return []
        done = []
        while self._jobs and (answer := self._advance(self._jobs[0])) is not None:
            done.append((self._jobs.popleft().ticket, answer))
        self._idle_since = time.monotonic()
        return done

    def close(self) -> None:
        """End the reader; whatever it reads is not answered."""
        process, self._process = self._process, None
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.close()
        if process is not None:
            process.kill()
            process.wait()

    def _advance(self, job: _Job) -> Model | RefusedError | None:
        """Continue the first job; return its result, None while it is under way."""
        if not job.deadline:
            job.deadline = time.monotonic() + self._limit
        try:
            if self._connection is None:
                self._start()
            assert self._connection is not None
            self._send(self._connection, job)
            if self._has_answer(self._connection, job):
                answer: Model | RefusedError = pickle.loads(job.answer[HEADER.size :])
                return answer
        except (OSError, EOFError) as error:
            return self._give_up(f"its reader ended: {self._fate() or error}")
        if time.monotonic() > job.deadline:
            return self._give_up(f"it took more than {self._limit:.0f} s to read it")
        return None

    @staticmethod
    def _send(connection: socket.socket, job: _Job) -> None:
        with contextlib.suppress(BlockingIOError):
            while job.unsent:
                job.unsent = job.unsent[connection.send(job.unsent[:CHUNK]) :]

    @staticmethod
    def _has_answer(connection: socket.socket, job: _Job) -> bool:
        with contextlib.suppress(BlockingIOError):
            while not (wanted := _wanted(job.answer)) or len(job.answer) < wanted:
                if wanted > LONGEST_ANSWER:
                    raise EOFError("the model is too large")
                chunk = connection.recv((wanted or HEADER.size) - len(job.answer))
                if not chunk:
                    raise EOFError("the connection was closed")
                job.answer += chunk
        return len(job.answer) >= HEADER.size and len(job.answer) == _wanted(job.answer)

    def _start(self) -> None:
        self._connection, other = socket.socketpair()
        self._connection.setblocking(False)
        with other:
            words = ("swarm_sim.world.model_reader", str(other.fileno()), str(os.getpid()))
            self._process = subprocess.Popen(
                start.command(*words), stdin=subprocess.DEVNULL, pass_fds=(other.fileno(),)
            )

    def _fate(self) -> str:
        """Return how the reader ended, if it did."""
        if self._process is None:
            return ""
        try:
            code = self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            return ""
        return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"

    def _give_up(self, why: str) -> RefusedError:
        self.close()
        return RefusedError(Reason.BAD_MODEL, f"the model was not read: {why}")


def _wanted(answer: bytearray) -> int:
    """Return the length [bytes] of an answer, header included; 0 while that is unknown."""
    if len(answer) < HEADER.size:
        return 0
    return HEADER.size + int(HEADER.unpack_from(answer)[0])

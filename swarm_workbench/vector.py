"""Many worlds as one vector environment of Gymnasium, in this process or in several."""

from __future__ import annotations

import itertools
import math
import mmap
import multiprocessing
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection
from typing import Annotated, Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from msgspec import Meta
from numpy.typing import DTypeLike, NDArray

from swarm_common.files.convert import convert
from swarm_common.model.errors import ConfigError, SwarmError, UnknownNameError
from swarm_common.model.schema import Count, Seed
from swarm_workbench.observation import FLAT
from swarm_workbench.team import EnvOptions, LearningTeam

MODES = {mode.name.lower(): mode for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP)}
BUFFERS = 2  # of observations: those of the step before stay as they were
Arrays = dict[str, NDArray[Any]]


def spaces_of(team: LearningTeam) -> tuple[spaces.Space[Any], spaces.Box]:
    """Return the spaces of an observation and of an action of one robot."""
    parts = {
        part: spaces.Box(low, high, shape, np.float32)
        for part, (shape, low, high) in team.bounds.items()
    }
    most = team.most.astype(np.float32)
    actions = spaces.Box(-most, most, dtype=np.float32)
    if team.options.observation == "dict":
        return spaces.Dict(parts), actions
    low, high = (
        np.concatenate([np.ravel(getattr(box, end)) for box in parts.values()])
        for end in ("low", "high")
    )
    return spaces.Box(low, high, dtype=np.float32), actions


class _Worlds:
    """Some of the worlds, and their rows of the arrays that all share."""

    def __init__(self, options: EnvOptions, arrays: Arrays, first: int, count: int) -> None:
        """Read the worlds; `first` is the index of the first of them."""
        self._teams = [LearningTeam(options) for _ in range(count)]
        robots = options.robots
        self._rows = [
            slice((first + index) * robots, (first + index + 1) * robots) for index in range(count)
        ]
        self._arrays = arrays
        self._ended = [np.zeros(robots, np.bool_) for _ in self._teams]

    def reset(self, seeds: Sequence[int | None], options: Any, buffer: int) -> None:
        """Begin anew in all worlds."""
        for team, rows, seed, ended in zip(
            self._teams, self._rows, seeds, self._ended, strict=True
        ):
            team.reset(seed, options)
            if team.count != team.options.robots:
                raise ConfigError(
                    f"robots is {team.count}, of {team.options.robots}: the rows of a vector"
                    " environment are fixed; make one for each number of robots"
                )
            ended[:] = False
            self._write(team, rows, buffer)

    def step(self, buffer: int, in_same_step: bool) -> None:
        """Drive for a step; robots whose episodes ended begin anew, in this step or the next."""
        arrays = self._arrays
        for team, rows, ended in zip(self._teams, self._rows, self._ended, strict=True):
            actions = np.where(ended[:, None], 0.0, arrays["act"][rows])
            rewards, reached, contacts = results = team.step(actions)
            if ended.any():  # they stood, and only begin
                for each in results:
                    each[ended] = 0
                team.renew(ended)
            ends, late = team.is_done, team.is_late & ~team.is_done
            arrays["reward"][rows], arrays["end"][rows], arrays["cut"][rows] = rewards, ends, late
            arrays["reached"][rows], arrays["contact"][rows] = reached, contacts
            ended[:] = ends | late
            if in_same_step and ended.any():
                self._write(team, rows, BUFFERS)
                team.renew(ended)
                ended[:] = False
            self._write(team, rows, buffer)

    def frames(self) -> tuple[Any, ...]:
        """Return a picture of each world."""
        return tuple(team.frame() for team in self._teams)

    def _write(self, team: LearningTeam, rows: slice, buffer: int) -> None:
        seen = team.seen()
        for part, values in (seen if isinstance(seen, dict) else {FLAT: seen}).items():
            self._arrays[part][buffer, rows] = values


class SwarmVectorEnv(VectorEnv):  # type: ignore[misc]
    """A row for each robot of each world; see `gym.make_vec`.

    An observation is a view that the step after the next one overwrites. `infos` have `reached` and
    `contact` (num_envs,).
    """

    def __init__(self, worlds: Any, options: EnvOptions, processes: Any, autoreset: str) -> None:
        """Start the processes.

        Raises:
            SwarmError: If an option makes no sense.
        """
        worlds = convert(worlds, Count, "n")
        processes = convert(processes, Annotated[int, Meta(ge=1, le=worlds)], "processes")
        if autoreset not in MODES:
            raise UnknownNameError("autoreset", str(autoreset), MODES)
        if options.render_mode == "human" or (options.render_mode and processes > 1):
            raise ConfigError(
                "a vector environment in this process alone draws, and 'rgb_array' only;"
                " watch one world in SwarmEnv"
            )
        mode = MODES[autoreset]
        self._in_same_step = mode is AutoresetMode.SAME_STEP
        self.metadata = {"autoreset_mode": mode, "render_modes": ["rgb_array"], "render_fps": 30}
        self.render_mode = options.render_mode
        model = LearningTeam(options)
        self.single_observation_space, self.single_action_space = spaces_of(model)
        self.num_envs = rows = worlds * options.robots
        self.observation_space = batch_space(self.single_observation_space, rows)
        self.action_space = batch_space(self.single_action_space, rows)
        self._model, self._worlds = model, worlds
        self._arrays = _shared_arrays(model, rows)
        self._step, self._has_begun = 0, False
        bounds = np.linspace(0, worlds, processes + 1).round().astype(int).tolist()
        self._shares = list(itertools.pairwise(bounds))
        self._own: _Worlds | None = None
        self._workers: list[_Worker] = []
        if processes == 1:
            self._own = _Worlds(options, self._arrays, 0, worlds)
        else:
            for first, end in self._shares:
                self._workers.append(_Worker(options, self._arrays, first, end - first))

    @property
    def options(self) -> EnvOptions:
        """All options, also those that were not given."""
        return self._model.options

    def reset(
        self, *, seed: Any = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin anew in all worlds.

        Args:
            seed: Seed of the first world, the others' follow; or one for each world.
            options: Options as of `SwarmEnv.reset`, for every world.

        Raises:
            SwarmError: If they make no sense.
        """
        if seed is None or isinstance(seed, int | np.integer):
            first = None if seed is None else convert(int(seed), Seed, "seed")
            seeds = [None if first is None else first + k for k in range(self._worlds)]
        else:
            seeds = list(seed)
            if len(seeds) != self._worlds:
                raise ConfigError(f"seed has {len(seeds)} entries; expected {self._worlds}")
        self._step += 1
        buffer = self._step % BUFFERS
        calls = [("reset", seeds[a:b], options, buffer) for a, b in self._shares]
        self._call(calls)
        self._has_begun = True
        return self._seen(buffer), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Drive for a step; return observations, rewards, terminations, truncations and infos.

        Raises:
            SwarmError: If an action makes no sense, or nothing was reset.
        """
        if not self._has_begun:
            raise SwarmError("no episode is under way: call reset()")
        if np.shape(actions) != self.action_space.shape:
            raise ConfigError(
                f"actions has the shape {np.shape(actions)}; expected {self.action_space.shape}"
            )
        if not np.isfinite(actions).all():
            self._model.actions_of(dict(enumerate(actions)))  # says which one
        arrays = self._arrays
        arrays["act"][:] = actions
        self._step += 1
        buffer = self._step % BUFFERS
        self._call([("step", buffer, self._in_same_step)] * len(self._shares))
        ends, cuts = arrays["end"].copy(), arrays["cut"].copy()
        infos: dict[str, Any] = {name: arrays[name].copy() for name in ("reached", "contact")}
        if self._in_same_step and (ends | cuts).any():
            infos |= self._finals(ends | cuts)
        return self._seen(buffer), arrays["reward"].copy(), ends, cuts, infos

    def _finals(self, ended: NDArray[np.bool_]) -> dict[str, Any]:
        """Return the last observations of episodes that ended, as Gymnasium has them."""
        last = self._seen(BUFFERS)
        finals = np.full(self.num_envs, None, object)
        for row in np.flatnonzero(ended):
            finals[row] = (
                {part: rows[row].copy() for part, rows in last.items()}
                if isinstance(last, dict)
                else last[row].copy()
            )
        return {"final_obs": finals, "_final_obs": ended}

    def render(self) -> tuple[Any, ...] | None:
        """Return a picture of each world with `render_mode="rgb_array"`, None without."""
        return self._own.frames() if self._own is not None and self.render_mode else None

    def close_extras(self, **_: Any) -> None:
        """End the processes."""
        for worker in self._workers:
            worker.close()
        self._workers = []

    def _call(self, calls: Sequence[tuple[Any, ...]]) -> None:
        if self._own is not None:
            name, *arguments = calls[0]
            getattr(self._own, name)(*arguments)
            return
        if not self._workers:
            raise SwarmError("the vector environment is closed")
        for worker, call in zip(self._workers, calls, strict=True):
            worker.send(call)
        faults = [worker.receive() for worker in self._workers]
        for fault in faults:
            if fault is not None:
                raise fault

    def _seen(self, buffer: int) -> Any:
        arrays = self._arrays
        if FLAT in arrays:
            return arrays[FLAT][buffer]
        return {part: arrays[part][buffer] for part in self._model.bounds}


def _shared_arrays(model: LearningTeam, rows: int) -> Arrays:
    """Return the arrays that all processes write, in memory that forked ones share."""
    space, _ = spaces_of(model)
    parts = space.spaces if isinstance(space, spaces.Dict) else {FLAT: space}
    shapes: dict[str, tuple[tuple[int, ...], DTypeLike]] = {
        part: ((BUFFERS + 1, rows, *box.shape), np.float32) for part, box in parts.items()
    }
    shapes |= {"act": ((rows, len(model.most)), np.float64), "reward": ((rows,), np.float64)}
    shapes |= {name: ((rows,), np.bool_) for name in ("end", "cut", "reached", "contact")}
    arrays: Arrays = {}
    for name, (shape, kind) in shapes.items():
        memory = mmap.mmap(-1, math.prod(shape) * np.dtype(kind).itemsize)
        arrays[name] = np.frombuffer(memory, kind, math.prod(shape)).reshape(shape)
    return arrays


class _Worker:
    """A process with some of the worlds."""

    def __init__(self, options: EnvOptions, arrays: Arrays, first: int, count: int) -> None:
        """Fork it: it shares the arrays, and callables of the options pass."""
        context = multiprocessing.get_context("fork")
        self._pipe, end = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(end, self._pipe, options, arrays, first, count), daemon=True
        )
        self._process.start()
        end.close()

    def send(self, call: tuple[Any, ...]) -> None:
        """Let it do something."""
        try:
            self._pipe.send(call)
        except OSError:
            raise self._gone() from None

    def receive(self) -> Exception | None:
        """Wait until it is done; return what went wrong."""
        try:
            fault: Exception | None = self._pipe.recv()
        except (EOFError, OSError):
            return self._gone()
        return fault

    def _gone(self) -> SwarmError:
        self._process.join(timeout=1.0)
        return SwarmError(
            f"a process of the vector environment ended with exit code {self._process.exitcode};"
            " make another environment"
        )

    def close(self) -> None:
        """End it."""
        self._pipe.close()
        self._process.join(timeout=5.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _serve(
    pipe: Connection, other: Connection, options: EnvOptions, arrays: Arrays, first: int, count: int
) -> None:
    """Do what the pipe says until it is closed."""
    other.close()
    worlds: _Worlds | None = None
    while True:
        try:
            name, *arguments = pipe.recv()
        except (EOFError, KeyboardInterrupt):
            return
        fault: Exception | None = None
        try:
            worlds = worlds or _Worlds(options, arrays, first, count)
            getattr(worlds, name)(*arguments)
        except Exception as error:
            fault = error
        try:
            pipe.send(fault)
        except OSError:
            return
        except Exception:  # an error that does not pass
            pipe.send(SwarmError(f"{type(fault).__name__}: {fault}"))

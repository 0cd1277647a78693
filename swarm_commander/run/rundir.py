"""The folder of a run: parameters, logs, report, and what another terminal must source."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shlex
import shutil
import sys
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path

from swarm_common.files.resources import LATEST, RUNS
from swarm_common.middleware import other_ros, ros_env
from swarm_common.model.errors import ConfigError


class RunFolder:
    """Paths within one run's folder."""

    def __init__(self, path: Path) -> None:
        """Name the paths; nothing is created."""
        self.path = path.absolute()
        self.params = self.path / "params"
        self.logs = self.path / "logs"
        self.configs = self.path / "config"
        self.trace = self.path / "trace"
        self.rviz = self.path / "rviz"
        self.foxglove = self.path / "foxglove"
        self.recording = self.path / "recording"
        self.plots = self.path / "plots"
        self.report = self.path / "report.json"
        self.page = self.path / "report.html"
        self.verdict = self.configs / "verdict.json"
        self._lock: int | None = None

    def claim(self) -> None:
        """Make the folder and keep other runs out of it until this process ends or `release`.

        Raises:
            ConfigError: If another run has it.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            raise ConfigError(
                f"another run writes to {self.path}; wait for its end, or choose another folder "
                "with --run-dir"
            ) from None
        except OSError:
            pass  # this disk lends no locks (NFS: none on folders); the run goes on without
        self._lock = descriptor

    def release(self) -> None:
        """Let other runs use the folder."""
        descriptor, self._lock = self._lock, None
        if descriptor is not None:
            os.close(descriptor)

    def log(self, name: str) -> Path:
        """Return the log file of a process."""
        return self.logs / f"{name}.log"


def create_run_folder(chosen: str | Path | None, now: datetime) -> RunFolder:
    """Make the folder of a run; what an earlier run left in it is removed.

    Args:
        chosen: --run-dir; None for a new folder in `runs/`, to which `runs/latest` then points.

    Returns:
        The folder, claimed.

    Raises:
        ConfigError: If it cannot be written, or has something else in it than a run.
    """
    folder = RunFolder(Path(chosen or RUNS / now.strftime("%Y-%m-%d_%H-%M-%S")))
    _check_text(folder.path)
    try:
        if chosen is None:
            folder = RunFolder(_made(folder.path))
        _check_is_run(folder)
        folder.claim()
        for old in (folder.rviz, folder.foxglove, folder.recording, folder.plots):
            shutil.rmtree(old, ignore_errors=True)
        for old in (folder.params, folder.logs, folder.configs, folder.trace):
            shutil.rmtree(old, ignore_errors=True)
            old.mkdir(parents=True)
        for file in (folder.report, folder.page):
            file.unlink(missing_ok=True)
        if chosen is None:
            _point_latest(folder.path)
    except OSError as error:
        raise ConfigError(
            f"cannot write the run folder {folder.path}: {error.strerror};"
            " choose another with --run-dir"
        ) from None
    return folder


def _check_text(path: Path) -> None:
    """Refuse a folder whose name cannot be written in UTF-8, as configurations and reports are."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        shown = os.fsencode(path).decode(errors="replace")
        raise ConfigError(
            f"the run folder {shown} has a name that is not UTF-8; choose another with --run-dir"
        ) from None


def _check_is_run(folder: RunFolder) -> None:
    """Refuse a folder with files in it that no run can have left there."""
    if not folder.path.is_dir() or not any(folder.path.iterdir()):
        return
    if not (folder.logs.is_dir() and folder.configs.is_dir()):
        raise ConfigError(
            f"--run-dir {folder.path} is not empty and no earlier run's folder;"
            " choose a new or an empty one"
        )


def _made(path: Path) -> Path:
    """Return a new folder of this name, or of one with a number where others are faster."""
    candidate, number = path, 1
    while True:
        try:
            candidate.mkdir(parents=True)
        except FileExistsError:
            if not os.path.lexists(candidate):  # it is the folder above that is none
                raise
            number += 1
            candidate = path.with_name(f"{path.name}-{number}")
        else:
            return candidate


def _point_latest(run: Path) -> None:
    """Let the link `latest` lead to a run; a disk without links has none."""
    link = run.parent / LATEST
    fresh = run.parent / f".{LATEST}-{os.getpid()}"
    with contextlib.suppress(OSError):
        fresh.unlink(missing_ok=True)
        fresh.symlink_to(run.name)
        fresh.replace(link)
    with contextlib.suppress(OSError):
        fresh.unlink(missing_ok=True)


def write_env_sh(folder: RunFolder, environment: Mapping[str, str]) -> None:
    """Write `env.sh`, which another terminal sources to see this swarm.

    Args:
        environment: Variables of the swarm; those of `ros_env.VARIABLES` that it lacks are unset
            there.
    """
    programs = shlex.quote(str(Path(sys.prefix) / "bin"))
    lines = [  # what is not set here may be set there, for another swarm
        f"export {name}={shlex.quote(environment[name])}"
        if name in environment
        else f"unset {name}"
        for name in ros_env.VARIABLES
    ]
    if other_ros.is_own_ros():  # which has but one middleware
        lines.append(f"unset {other_ros.RMW}")
    lines.append(f'case ":$PATH:" in *:{programs}:*) ;; *) export PATH={programs}:"$PATH" ;; esac')
    text = "# Source this in another terminal to see this swarm.\n" + "\n".join(lines) + "\n"
    (folder.path / "env.sh").write_text(text, encoding="utf-8")


def end_of(log: Path) -> str:
    """Return how a log file ends, which need not be why its process did.

    Raises:
        ConfigError: If it cannot be read.
    """
    try:
        lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
    except OSError as error:
        raise ConfigError(f"cannot read {log}: {error.strerror}") from None
    line = next((line.strip() for line in reversed(lines) if line.strip()), None)
    return f"its log is empty ({log})" if line is None else f"its log ends with: {line} ({log})"

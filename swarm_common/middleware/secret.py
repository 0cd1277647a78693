"""The secret that the hosts of a swarm share: made and shown by the world's host.

It never stands on a command line, where every user of a machine could read it, nor in a log or a
report; processes get it in their environment and take it out of there.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import MutableMapping
from pathlib import Path

from swarm_common.model.errors import ConfigError

VARIABLE = "SWARM_SECRET"
FILE_VARIABLE = "SWARM_SECRET_FILE"
LEAST = 16  # characters; a short one could be guessed from the messages
MOST = 1024
BYTES = 16  # of one that is made


def given_secret(environment: MutableMapping[str, str]) -> str:
    """Return the secret that the user gave and take it out of the environment; empty without one.

    Args:
        environment: Usually os.environ; what it says of the secret is removed.
    """
    text = environment.pop(VARIABLE, "").strip()
    path = environment.pop(FILE_VARIABLE, "")
    where = VARIABLE
    if path and not text:
        where = f"{FILE_VARIABLE} ({path})"
        text = _read(Path(path), where)
    if (text or path) and not LEAST <= len(text) <= MOST:
        raise ConfigError(f"{where}: the secret has {len(text)} characters; {LEAST} or more needed")
    return text


def own_secret(environment: MutableMapping[str, str]) -> str:
    """Return the secret of a world's host: the one given, else its own, made once and kept.

    It outlives a run, so that hosts that are started again by a script need no new one.
    """
    given = given_secret(environment)
    if given:
        return given
    path = secret_path(environment)
    try:
        return _kept(path)
    except OSError:
        return secrets.token_urlsafe(BYTES)  # no place to keep it: for this run


def secret_path(environment: MutableMapping[str, str]) -> Path:
    """Return where a world's host keeps the secret that it made."""
    base = environment.get("XDG_STATE_HOME", "")
    home = environment.get("HOME", "") or "/nonexistent"
    folder = Path(base) if base else Path(home) / ".local" / "state"
    return folder / "swarm-workbench" / "secret"


def _kept(path: Path) -> str:
    """Return the secret in a file of this user only; it is made if there is no valid one."""
    if path.is_file() and not path.stat().st_mode & 0o077:
        text = path.read_text(encoding="utf-8", errors="replace").strip()
        if LEAST <= len(text) <= MOST:
            return text
    text = secrets.token_urlsafe(BYTES)
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}-{os.getpid()}")
    fresh.unlink(missing_ok=True)
    descriptor = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        file.write(text + "\n")
    fresh.replace(path)
    return text


def _read(path: Path, where: str) -> str:
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return file.read(MOST + 1).strip()
    except OSError as error:
        raise ConfigError(f"{where}: cannot be read: {error.strerror}") from None

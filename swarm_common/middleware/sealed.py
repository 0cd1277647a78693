"""Sealed messages between hosts: written by a holder of the secret, for this run, just now.

HMAC-SHA256 (RFC 2104) over kind, run, sender, number and content. The kind prevents a message of
one side from being accepted as one of the other side; the run keeps an earlier run's messages out
of this one; the number, which only grows, keeps a message from being heard twice.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from swarm_common.model.errors import SwarmError

MOST = 16 << 20  # bytes of a message
NAME_LIMIT = 200  # characters of a run or a sender
TAG = 32  # bytes of a seal


class ForgedError(SwarmError):
    """A message was not made by a holder of the secret, or was made for another purpose."""


@dataclass(frozen=True, slots=True)
class Letter:
    """Content of a sealed message."""

    run: str  # of the swarm
    sender: str  # different for each process that ever speaks
    content: Any  # what it is about


def tag(secret: str, *parts: bytes) -> bytes:
    """Return the seal (32 bytes) of some parts; where one ends and the next begins counts."""
    joined = b"".join(struct.pack("<I", len(part)) + part for part in parts)
    return hmac.digest(secret.encode(), joined, hashlib.sha256)


class Sealer:
    """Seals the messages of one kind from one sender."""

    def __init__(self, secret: str, kind: str, sender: str) -> None:
        """Begin with message 1.

        Args:
            kind: Kind of the messages; one of another kind is not accepted.
            sender: Different for each process that ever speaks.
        """
        self._secret = secret
        self._kind = kind
        self._sender = sender
        self._number = 0

    def seal(self, run: str, content: Mapping[str, Any]) -> str:
        """Return the text of a message."""
        self._number += 1
        body = json.dumps(content)
        seal = _seal(self._secret, self._kind, run, self._sender, self._number, body)
        return json.dumps(
            {"run": run, "sender": self._sender, "number": self._number, "body": body, "seal": seal}
        )


class Opener:
    """Opens the messages of one kind, each once."""

    def __init__(self, secret: str, kind: str) -> None:
        """Begin with nothing heard."""
        self._secret = secret
        self._kind = kind
        self._newest: dict[tuple[str, str], int] = {}

    def open(self, text: str) -> Letter | None:
        """Return the content of a message; None for one that was heard already, or is overtaken.

        Raises:
            ForgedError: If its seal is not right.
        """
        try:
            if len(text) > MOST:
                raise ValueError("too long")
            data = json.loads(text)
            run, sender, number = data["run"], data["sender"], data["number"]
            body, seal = data["body"], data["seal"]
            is_fit = all(isinstance(part, str) for part in (run, sender, body, seal))
            if not is_fit or type(number) is not int or len(run) + len(sender) > NAME_LIMIT:
                raise ValueError("members of other kinds")
            right = _seal(self._secret, self._kind, run, sender, number, body)
            is_right = hmac.compare_digest(right.encode(), seal.encode())
        except (ValueError, KeyError, TypeError, RecursionError) as cause:
            raise ForgedError(f"no sealed message: {cause!r}"[:NAME_LIMIT]) from None
        if not is_right:
            raise ForgedError("the seal is not that of this swarm's secret")
        if number <= self._newest.get((run, sender), 0):
            return None
        self._newest[run, sender] = number
        return Letter(run, sender, json.loads(body))


def _seal(secret: str, kind: str, run: str, sender: str, number: int, body: str) -> str:
    return tag(secret, *(part.encode() for part in (kind, run, sender, str(number), body))).hex()

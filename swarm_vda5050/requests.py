"""Requests of a robot that its fleet control grants, queues, rejects or revokes; of version 3.0."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import NamedTuple

from swarm_common.model.records import FloatArray
from swarm_vda5050.messages import GrantType, Response

ASK_AGAIN = 10.0  # [s] after a rejection
REQUESTED, EXPIRED = "REQUESTED", "EXPIRED"
LOST = (str(GrantType.REVOKED), EXPIRED)


class RequestKey(NamedTuple):
    """Subject of a request: a zone, a way through a zone, or an edge's corridor."""

    kind: str  # requestType
    name: str  # zoneId or edgeId
    order_id: str = ""
    sequence_id: int = 0  # of the edge, the last one of a way


@dataclass(slots=True)
class GrantRequest:
    """One request."""

    number: int
    status: str = REQUESTED
    expiry: datetime | None = None
    way: FloatArray | None = None  # (n, 2) [m] in map, of REPLANNING

    @property
    def is_asked(self) -> bool:
        """Whether it has no answer yet."""
        return self.status == REQUESTED

    @property
    def is_granted(self) -> bool:
        """Whether the robot may do what it asked for."""
        return self.status == GrantType.GRANTED

    @property
    def is_lost(self) -> bool:
        """Whether it no longer may."""
        return self.status in LOST


@dataclass(slots=True)
class RequestBook:
    """All requests of a robot that are open; each attempt has a number of its own."""

    open: dict[RequestKey, GrantRequest] = field(default_factory=dict)
    _rejected: dict[RequestKey, datetime] = field(default_factory=dict)  # and when
    _count: int = 0

    def respond(self, answers: Sequence[Response]) -> list[str]:
        """Receive answers; return what is wrong with them.

        Those to requests that are gone are ignored. Whatever takes a permission back does so.
        """
        by_number = {str(request.number): request for request in self.open.values()}
        problems = []
        for answer in answers:
            request = by_number.get(answer.request_id)
            if request is None:
                if not self._was_issued(answer.request_id):
                    problems.append(f"there was no request '{answer.request_id:.80}'")
                continue
            grant = answer.grant_type
            is_known = request.is_granted or request.is_lost
            if grant is GrantType.REVOKED and not is_known:
                problems.append(f"the request {request.number} is revoked, but was not granted")
                grant = GrantType.REJECTED
            elif grant is GrantType.REJECTED and is_known:
                if request.is_granted:
                    text = f"the request {request.number} is rejected after it was granted"
                    problems.append(text)
                grant = GrantType.REVOKED
            elif grant is GrantType.QUEUED:
                continue  # the schema has no such status
            request.status, request.expiry = str(grant), answer.lease_expiry
        return problems

    def _was_issued(self, name: str) -> bool:
        is_number = name.isascii() and name.isdigit() and len(name) < 10
        return is_number and name == str(int(name)) and 1 <= int(name) <= self._count

    def look(
        self,
        key: RequestKey,
        utc: datetime,
        *,
        is_needed: bool,
        is_begun: bool,
        way: Callable[[], FloatArray] | None = None,
    ) -> GrantRequest | None:
        """Settle a request, ask for what is needed, and return what is open then.

        Args:
            utc: Time at which leases are compared with their end.
            is_begun: Whether the robot does already what it asked for.
            way: Returns the way (n, 2) [m] in map of a new request.
        """
        self.settle(key, utc, is_needed=is_needed, is_begun=is_begun)
        last = self._rejected.get(key)
        may_ask = last is None or (utc - last).total_seconds() > ASK_AGAIN
        if is_needed and key not in self.open and may_ask:
            self._count += 1
            self.open[key] = GrantRequest(self._count, way=None if way is None else way())
        return self.open.get(key)

    def settle(self, key: RequestKey, utc: datetime, *, is_needed: bool, is_begun: bool) -> None:
        """Let the lease of a request end, and drop it if it is over.

        Args:
            utc: Time at which leases are compared with their end.
            is_begun: Whether the robot does already what it asked for: then what is lost stays.
        """
        request = self.open.get(key)
        if request is None:
            return
        if request.is_granted and request.expiry is not None and utc >= request.expiry:
            request.status = EXPIRED
        if request.status == GrantType.REJECTED:
            self.give_up(key, utc)
        elif not is_begun and (request.is_lost or not is_needed):
            del self.open[key]

    def give_up(self, key: RequestKey, utc: datetime) -> None:
        """Drop a request, and wait before the next one."""
        self.open.pop(key, None)
        self._rejected = {
            each: at for each, at in self._rejected.items()
            if (utc - at).total_seconds() <= ASK_AGAIN
        }  # fmt: skip
        self._rejected[key] = utc

    def keep(self, is_kept: Callable[[RequestKey], bool]) -> None:
        """Drop all other requests."""
        self.open = {key: each for key, each in self.open.items() if is_kept(key)}

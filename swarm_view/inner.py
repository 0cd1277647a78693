"""viser's own port: it takes only connections that bring a key."""

from __future__ import annotations

import contextlib
import hmac
import http
from collections.abc import Callable, Iterator
from typing import Any

import websockets.asyncio.server as websockets_server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

Answer = Callable[[ServerConnection, Request], Response | None]


@contextlib.contextmanager
def admitting(header: str, key: str) -> Iterator[None]:
    """Let the viser server that is created within take only requests with a key.

    viser has no setting for it: it answers every page and every websocket of whatever origin. So
    what it serves with is given one question more. A test asks the port without the key.

    Args:
        header: Name of the header that carries the key.
        key: Its value.
    """
    serve = websockets_server.serve

    def serve_guarded(*arguments: Any, process_request: Answer | None, **options: Any) -> Any:
        def answer(connection: ServerConnection, request: Request) -> Response | None:
            keys = request.headers.get_all(header)
            if len(keys) != 1 or not hmac.compare_digest(keys[0].encode(), key.encode()):
                return connection.respond(http.HTTPStatus.FORBIDDEN, "Not this way.\n")
            return None if process_request is None else process_request(connection, request)

        return serve(*arguments, process_request=answer, **options)

    websockets_server.serve = serve_guarded  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        websockets_server.serve = serve  # type: ignore[misc]

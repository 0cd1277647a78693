"""The private parts of viser that we use, all in one place; written for viser 1.1.

viser has no public way to serve its page to some only, to know the address that a page was opened
with, to set a camera's position and target without its orientation, to show a
node of all pages differently on one, or to use what a browser offers beside its scene.
"""

from __future__ import annotations

import contextlib
import hmac
import http
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import viser
import websockets.asyncio.server as websockets_server
from viser import _messages
from viser.infra import WebsockServer
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from swarm_common.model.records import FloatArray
from swarm_common.process.private_parts import require

PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
PARTS: tuple[tuple[Any, str], ...] = (
    (_messages, "SetCameraLookAtMessage"),
    (_messages, "SetCameraPositionMessage"),
    (_messages, "SceneNodeUpdateMessage"),
    (_messages, "RunJavascriptMessage"),
    (_messages, "SetSceneNodeVisibilityMessage"),
    (viser.ClientHandle.__init__, "_websock_connection"),
    (viser.ViserServer.__init__, "_websock_server"),
    (WebsockServer.__init__, "_live_connections"),
)
require("viser", __name__, PARTS)

Answer = Callable[[ServerConnection, Request], Response | None]


@contextlib.contextmanager
def admitting(header: str, key: str) -> Iterator[None]:
    """Make the viser server that is created within accept only requests with a key in a header.

    viser has no setting for it: it answers every page and every websocket of any origin. So its
    request handler is wrapped with one more check. A test asks the port without the key.
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


def look(client: viser.ClientHandle, target: FloatArray, position: FloatArray) -> None:
    """Make a page look from a position (3,) at a target (3,), both in map.

    viser's own setters compute the camera's orientation twice, which is wasted work.
    """
    queue = client._websock_connection.queue_message
    x, y, z = position.tolist()
    target_x, target_y, target_z = target.tolist()
    with client.atomic():
        queue(_messages.SetCameraPositionMessage((x, y, z)))
        queue(_messages.SetCameraLookAtMessage((target_x, target_y, target_z)))


def update_for(client: viser.ClientHandle, name: str, **updates: Any) -> None:
    """Change a node of the scene that all pages share, for one page only.

    A later change of the same property by the server applies to all pages again.
    """
    message = _messages.SceneNodeUpdateMessage(name, updates)
    client._websock_connection.queue_message(message)


def set_visible(client: viser.ClientHandle, name: str, *, visible: bool) -> None:
    """Show or hide a node of the scene that all pages share, on one page only."""
    message = _messages.SetSceneNodeVisibilityMessage(name, visible)
    client._websock_connection.queue_message(message)


def run_script(client: viser.ClientHandle, source: str) -> None:
    """Run JavaScript on a page; viser has no public way to use what it does so for Plotly."""
    client._websock_connection.queue_message(_messages.RunJavascriptMessage(source))


def id_on_page(field: viser.GuiInputHandle[Any]) -> str:
    """Return the id by which a page's own script finds an input field."""
    return str(field._impl.uuid)


def request_of(server: viser.ViserServer, client_id: int) -> Any:
    """Return the request that a page's connection was opened with; None if it is gone."""
    connection: Any = server._websock_server._live_connections.get(client_id)
    return None if connection is None else connection.request

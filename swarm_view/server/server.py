"""viser behind our gate: the pages that connected, and their addresses."""

from __future__ import annotations

import asyncio
import contextlib
import io
import secrets
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import viser

from swarm_common.files.map_io import WORLD_FILE
from swarm_common.middleware.addresses import own_addresses
from swarm_view.scene.viser_compat import admitting, request_of
from swarm_view.server.http_gate import KEY_HEADER, HttpGate, query_of
from swarm_view.state.link import PARAMETERS, Viewpoint, place_of

EVERYWHERE = ("0.0.0.0", "::")
LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
AMBIENT, SUN = 1.9, 1.5
START_TIMEOUT = STOP_TIMEOUT = 10.0  # [s]


class Server:
    """The web side of the view; `viser` has the scene and the panel that all pages share."""

    def __init__(self, host: str, port: int, title: str = "") -> None:
        """Listen; port 0 for a free one.

        Args:
            title: Run and hall, at the top of the panel; empty if they are not known.

        Raises:
            AccessError: If the address is taken.
        """
        self._key = secrets.token_urlsafe(16)
        self._token = secrets.token_urlsafe(16)
        # Its banner shows the inner address.
        with contextlib.redirect_stdout(io.StringIO()), admitting(KEY_HEADER, self._key):
            self.viser = viser.ViserServer("127.0.0.1", 0, verbose=False)
        inner_port = self.viser.get_port()
        self._gate = HttpGate(host, port, names_of(host), inner_port, self._token, self._key)
        self._loop = self.viser.get_event_loop()
        try:
            starting = asyncio.run_coroutine_threadsafe(self._gate.start(), self._loop)
            starting.result(START_TIMEOUT)
        except BaseException:
            self.viser.stop()
            raise
        self._host = host
        self.viser.gui.configure_theme(
            show_logo=False, show_share_button=False, control_width="medium"
        )
        self.viser.gui.set_panel_label(title or None)
        scene = self.viser.scene
        scene.world_axes.visible = False
        # Colours mean something here, so the light is plain and casts no shadows.
        scene.configure_default_lights(False)
        scene.configure_environment_map(None)
        scene.add_light_ambient("/light", intensity=AMBIENT)
        scene.add_light_directional("/sun", intensity=SUN, position=(-4.0, -6.0, 10.0))

    @property
    def port(self) -> int:
        """That it listens on."""
        return self._gate.port

    def url(self, robot: str = "", place: Viewpoint | None = None) -> str:
        """Return the address of a robot's page, or of one that opens with all of a place."""
        pairs = (*(place or Viewpoint(robot)).pairs(), ("token", self._token))
        query = "&".join(f"{name}={value}" for name, value in pairs if value)
        host = socket.gethostname() if self._host in EVERYWHERE else _bracketed(self._host)
        return f"http://{host}:{self.port}/" + (f"?{query}" if query else "")

    def on_pages(
        self, on_open: Callable[[Any, Viewpoint], None], on_close: Callable[[int], None]
    ) -> None:
        """Call back, on the event loop, for each page with what its address says.

        Connections that did not come through the gate are not reported.
        """

        @self.viser.on_client_connect
        async def _(client: Any) -> None:
            request = request_of(self.viser, client.client_id)
            if request is not None and request.headers.get(KEY_HEADER) == self._key:
                on_open(client, place_of(*(query_of(request.path, name) for name in PARAMETERS)))

        @self.viser.on_client_disconnect
        async def _(client: Any) -> None:
            on_close(client.client_id)

    def stop(self) -> None:
        """Listen no more."""
        with contextlib.suppress(TimeoutError):  # of a loop that hangs
            asyncio.run_coroutine_threadsafe(self._gate.stop(), self._loop).result(STOP_TIMEOUT)
        with contextlib.redirect_stdout(io.StringIO()):
            self.viser.stop()


def title_of(world: str, run: Path) -> str:
    """Return hall and run in words; `world` is a name or path, empty if it is not known."""
    place = Path(world)
    hall = place.parent.name if place.name == WORLD_FILE else place.stem
    return " · ".join(filter(None, (hall, run.resolve().name)))


def names_of(host: str) -> set[str]:
    """Return what browsers may call a server that is bound to an address."""
    names = {*LOOPBACK, _bracketed(host)}
    if host in EVERYWHERE:
        names |= {socket.gethostname(), socket.getfqdn(), *own_addresses()}
    return names


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host

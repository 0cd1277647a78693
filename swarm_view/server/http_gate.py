"""The door to the view: serves the page, asks for the token, passes websockets on.

viser has neither an address per robot nor access control, so it listens on a port of its own on
the loopback interface (`inner`), which takes connections of this door only.

Every request must name this server as the user knows it (`Host`): a name of somebody else that
leads here, as in DNS rebinding, makes his page look like ours to the browser. Every request must
bring the token of the link that was printed. It is no cookie, which a browser would add to
requests that other pages make.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import http
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from swarm_common.model.errors import SwarmError
from swarm_view.scene.viser_compat import PAGE

HEAD_LIMIT = 32768  # bytes of a request's head
HEAD_TIMEOUT = 10.0  # [s] for it to arrive
HTTP_PORT = 80  # which browsers leave out
KEY_HEADER = "X-Swarm-Key"
DECISIVE = frozenset({"host", "origin", "upgrade", "connection", KEY_HEADER.lower()})
CHUNK = 1 << 16
SCRIPT = "".join(
    "<script>\n{\n" + Path(__file__).with_name(name).read_text("utf-8") + "}\n</script>"
    for name in ("page.js", "plan.js")
)


class AccessError(SwarmError):
    """The address cannot be listened on."""


@dataclass(frozen=True, slots=True)
class Head:
    """The head of an HTTP request."""

    raw: bytes
    target: str
    headers: dict[str, str]

    @property
    def path(self) -> str:
        """Path without the query."""
        return urlsplit(self.target).path

    @property
    def is_websocket(self) -> bool:
        """Whether it asks for a websocket."""
        return self.headers.get("upgrade", "").lower() == "websocket"

    def query(self, name: str) -> str:
        """Return a parameter of the query; empty without one."""
        return query_of(self.target, name)


class HttpGate:
    """Listens on the address that the user knows."""

    def __init__(
        self, host: str, port: int, names: Collection[str], inner_port: int, token: str, key: str
    ) -> None:
        """Store the settings; `start` listens.

        Args:
            port: To bind to; 0 for a free one.
            names: Names by which browsers may address this server.
            inner_port: Where viser listens on the loopback interface.
            token: Required in every request as `token=`.
            key: Tells viser's side that a connection comes from here.
        """
        self.port = port
        self._names = {name.lower() for name in names}
        self._host = host
        self._inner_port = inner_port
        self._token = token
        self._key = key
        self._server: asyncio.Server | None = None
        self._open: set[asyncio.Task[None] | None] = set()  # connections
        self._page = PAGE.read_text(encoding="utf-8").replace("<head>", "<head>" + SCRIPT, 1)

    async def start(self) -> None:
        """Begin to listen.

        Raises:
            AccessError: If the address is taken.
        """
        try:
            self._server = await asyncio.start_server(self._serve, self._host, self.port)
        except OSError as error:
            reason = error.strerror or str(error)
            raise AccessError(
                f"cannot listen on {self._host}:{self.port}: {reason}; choose another --port"
            ) from None
        self.port = self._server.sockets[0].getsockname()[1]

    async def stop(self) -> None:
        """Listen no more, and end all connections: browsers keep some without a request."""
        if self._server is not None:
            self._server.close()
        tasks = [task for task in self._open if task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await asyncio.sleep(0.0)  # in which their sockets are closed

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        self._open.add(task)
        try:
            async with asyncio.timeout(HEAD_TIMEOUT):
                raw = await reader.readuntil(b"\r\n\r\n")
            head = parse_head(raw)
            refusal = self._refusal(head)
            if refusal:
                writer.write(_response(403, "text/plain", refusal.encode()))
            elif head.is_websocket:
                await self._pass_on(head, reader, writer)
            elif head.path == "/":
                writer.write(_response(200, "text/html; charset=utf-8", self._page.encode()))
            else:
                writer.write(_response(404, "text/plain", b"There is nothing here.\n"))
            await writer.drain()
        except (OSError, ValueError, TimeoutError, EOFError, asyncio.LimitOverrunError):
            pass  # the browser went away, or it was none
        except asyncio.CancelledError:
            writer.transport.abort()  # the server is about to end: nothing is left to say
        finally:
            writer.close()
            self._open.discard(task)

    def _refusal(self, head: Head) -> str:
        """Return why a request is not admitted; empty if it is."""
        host = head.headers.get("host", "").lower()
        own = {f"{name}:{self.port}" for name in self._names}
        if self.port == HTTP_PORT:
            own |= self._names
        if host not in own:
            return "This is no name of this viewer; take the link that it printed.\n"
        # Pages of other origins must not drive robots through the user's browser.
        origin = head.headers.get("origin")
        is_foreign = origin is not None and origin.lower() != f"http://{host}"
        if is_foreign or (head.is_websocket and origin is None):
            return "Pages of other origins have no access.\n"
        if not hmac.compare_digest(head.query("token").encode(), self._token.encode()):
            return "The link needs its token; take the one that the viewer printed.\n"
        return ""

    async def _pass_on(
        self, head: Head, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        inner_reader, inner_writer = await asyncio.open_connection("127.0.0.1", self._inner_port)
        inner_writer.write(head.raw[:-2] + f"{KEY_HEADER}: {self._key}\r\n\r\n".encode())
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(_copy(reader, inner_writer))
                group.create_task(_copy(inner_reader, writer))
        except* OSError:
            pass
        finally:
            inner_writer.close()


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):
        while chunk := await reader.read(CHUNK):
            writer.write(chunk)
            await writer.drain()
    writer.close()


def parse_head(raw: bytes) -> Head:
    """Return the head of a request; raise ValueError if it is malformed."""
    lines = raw.decode("latin-1").split("\r\n")
    method, target, _ = lines[0].split(" ")
    if method != "GET" or len(raw) > HEAD_LIMIT:
        raise ValueError(f"unexpected request: {lines[0][:80]}")
    headers: dict[str, str] = {}
    for line in lines[1:]:
        name, _, value = line.partition(":")
        name = name.lower()
        is_odd = name != name.strip() or "\r" in line or "\n" in line
        if is_odd or (name in DECISIVE and name in headers):
            raise ValueError(f"ambiguous header: {line[:80]}")  # viser could read it otherwise
        if line:
            headers[name] = value.strip()
    return Head(raw, target, headers)


def query_of(target: str, name: str) -> str:
    """Return a parameter of a request's query; empty without one."""
    return parse_qs(urlsplit(target).query).get(name, [""])[0]


def _response(status: int, kind: str, body: bytes) -> bytes:
    lines = (
        f"HTTP/1.1 {status} {http.HTTPStatus(status).phrase}",
        f"Content-Type: {kind}",
        f"Content-Length: {len(body)}",
        "Cache-Control: no-store",
        "Referrer-Policy: no-referrer",
        "Connection: close",
    )
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + body

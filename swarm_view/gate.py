"""The door to the view: serves the page, asks for the token, passes websockets on.

viser has neither an address per robot nor access control, so it listens on a port of its own on
the loopback interface, and only this door is known to the user.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import http
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import viser

from swarm_common.errors import SwarmError

PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
HEAD_LIMIT = 32768  # bytes of a request's head
HEAD_TIMEOUT = 10.0  # [s] for it to arrive
KEY_HEADER = "X-Swarm-Key"
CHUNK = 1 << 16
# viser's client connects to the page's address without its query. This hands the query on.
SCRIPT = """<script>
const post = Worker.prototype.postMessage;
Worker.prototype.postMessage = function (message, ...rest) {
  if (message && message.type === "set_server" && !message.server.includes("?"))
    message = { ...message, server: message.server + location.search };
  return post.call(this, message, ...rest);
};
// react-three-fiber makes it passive; viser's client prevents its default when a drag begins.
const listen = EventTarget.prototype.addEventListener;
EventTarget.prototype.addEventListener = function (type, listener, options) {
  if (type === "pointerdown" && options && options.passive)
    options = { ...options, passive: false };
  return listen.call(this, type, listener, options);
};
document.title = "swarm" + (new URLSearchParams(location.search).get("robot") ?? "").replace(
  /^(.)/, " · $1");
</script>"""


class DoorError(SwarmError):
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


class Gate:
    """Listens on the address that the user knows."""

    def __init__(self, host: str, port: int, inner_port: int, token: str, key: str) -> None:
        """Keep what it needs.

        Args:
            host: To bind to.
            port: To bind to; 0 for a free one.
            inner_port: Where viser listens on the loopback interface.
            token: That every request must bring as `token=`; empty for none.
            key: That viser's side knows our connections by.
        """
        self.port = port
        self._host = host
        self._inner_port = inner_port
        self._token = token
        self._key = key
        self._server: asyncio.Server | None = None
        self._page = PAGE.read_text(encoding="utf-8").replace("<head>", "<head>" + SCRIPT, 1)

    async def start(self) -> None:
        """Begin to listen.

        Raises:
            DoorError: If the address is taken.
        """
        try:
            self._server = await asyncio.start_server(self._serve, self._host, self.port)
        except OSError as error:
            reason = error.strerror or str(error)
            raise DoorError(
                f"cannot listen on {self._host}:{self.port}: {reason}; choose another --port"
            ) from None
        self.port = self._server.sockets[0].getsockname()[1]

    def stop(self) -> None:
        """Listen no more."""
        if self._server is not None:
            self._server.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            async with asyncio.timeout(HEAD_TIMEOUT):
                raw = await reader.readuntil(b"\r\n\r\n")
            head = parse_head(raw)
            if not self._is_admitted(head):
                writer.write(_response(403, "text/plain", b"The link needs its token.\n"))
            elif head.is_websocket:
                await self._pass_on(head, reader, writer)
            elif head.path == "/":
                writer.write(_response(200, "text/html; charset=utf-8", self._page.encode()))
            else:
                writer.write(_response(404, "text/plain", b"There is nothing here.\n"))
            await writer.drain()
        except (OSError, ValueError, TimeoutError, EOFError, asyncio.LimitOverrunError):
            pass  # the browser went away, or it was none
        finally:
            writer.close()

    def _is_admitted(self, head: Head) -> bool:
        if self._token and not hmac.compare_digest(head.query("token"), self._token):
            return False
        # Pages of other origins must not drive robots through the user's browser.
        origin = head.headers.get("origin")
        return not head.is_websocket or urlsplit(origin or "").netloc == head.headers.get("host")

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
    """Copy until either side ends."""
    with contextlib.suppress(OSError):
        while chunk := await reader.read(CHUNK):
            writer.write(chunk)
            await writer.drain()
    writer.close()


def parse_head(raw: bytes) -> Head:
    """Return the head of a request.

    Raises:
        ValueError: If it is none.
    """
    lines = raw.decode("latin-1").split("\r\n")
    method, target, _ = lines[0].split(" ")
    if method != "GET" or len(raw) > HEAD_LIMIT:
        raise ValueError(f"unexpected request: {lines[0][:80]}")
    pairs = (line.partition(":") for line in lines[1:] if line)
    return Head(raw, target, {name.strip().lower(): value.strip() for name, _, value in pairs})


def query_of(target: str, name: str) -> str:
    """Return a parameter of a request's query; empty without one."""
    return parse_qs(urlsplit(target).query).get(name, [""])[0]


def _response(status: int, kind: str, body: bytes) -> bytes:
    lines = (
        f"HTTP/1.1 {status} {http.HTTPStatus(status).phrase}",
        f"Content-Type: {kind}",
        f"Content-Length: {len(body)}",
        "Cache-Control: no-cache",
        "Referrer-Policy: no-referrer",
        "Connection: close",
    )
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + body

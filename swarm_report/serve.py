"""A server of reports for the browser of this machine: a list of runs, each run, comparisons.

It listens on the loopback interface only. As in the viewer, a request must name this server as the
user knows it (`Host`), so that a page of somebody else whose name leads here (DNS rebinding) gets
nothing, and must have the token of the printed link, so that other users of the machine do not.
The token is a part of the path, so that links between pages need not repeat it.
"""

from __future__ import annotations

import hmac
import http
import secrets
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import ClassVar
from urllib.parse import parse_qs, quote, unquote, urlsplit

from swarm_common.model.errors import ConfigError, SwarmError
from swarm_report.compare import comparison_html
from swarm_report.document import PAGE, document_html
from swarm_report.run import RunData
from swarm_report.run_list import RunList, run_folders

LOOPBACK = "127.0.0.1"
NAMES = (LOOPBACK, "localhost")
MOST_COMPARED = 8
HTML, PLAIN = "text/html; charset=utf-8", "text/plain; charset=utf-8"


class ReportServer(ThreadingHTTPServer):
    """Serves the runs of a folder; `link` is its address with the token."""

    daemon_threads = True

    def __init__(self, runs: Path, port: int) -> None:
        """Begin to listen; port 0 for a free one.

        Raises:
            ConfigError: If there is no such folder, or the port is taken.
        """
        if not runs.is_dir():
            raise ConfigError(f"{runs} is not a folder; expected the one with the runs, like runs/")
        try:
            super().__init__((LOOPBACK, port), _Handler)
        except OSError as error:
            raise ConfigError(
                f"cannot listen on {LOOPBACK}:{port}: {error.strerror}; choose another --port"
            ) from None
        self.runs = runs
        self.list = RunList(runs)
        self.token = secrets.token_urlsafe(16)
        self.drawing = threading.Lock()  # matplotlib is drawn with by one thread at a time
        self.link = f"http://{LOOPBACK}:{self.server_port}/{self.token}/"

    def page(self, path: str, query: str) -> str | None:
        """Return the page at a path below the token; None if there is none."""
        if path == "":
            return self.list.page()
        known = run_folders(self.runs)  # no name that is asked for becomes a path
        kind, _, name = path.partition("/")
        if kind == "run" and unquote(name) in known:
            return self._report(known[unquote(name)])
        chosen = [known[name] for name in parse_qs(query).get("run", []) if name in known]
        if path == "compare" and 2 <= len(chosen) <= MOST_COMPARED:
            with self.drawing:
                return comparison_html([RunData(folder) for folder in chosen])
        if path == "compare":
            raise ConfigError(f"choose 2 to {MOST_COMPARED} runs")
        return None

    def _report(self, folder: Path) -> str:
        """Return the page of a run; it is drawn now if the run was killed or still goes on."""
        page = folder / PAGE
        if page.is_file() and (folder / "report.json").is_file():
            return page.read_text(encoding="utf-8")
        with self.drawing:
            return document_html(RunData(folder))


class _Handler(BaseHTTPRequestHandler):
    server: ReportServer
    server_version = "swarm-report"
    sys_version = ""
    timeout = 10.0  # [s] for a request to arrive
    refused: ClassVar[str] = "This is no name of this server; take the link that it printed.\n"

    def do_GET(self) -> None:
        """Answer a request."""
        host = self.headers.get_all("Host") or []
        own = {f"{name}:{self.server.server_port}" for name in NAMES}
        if len(host) != 1 or host[0].lower() not in own:
            self._answer(403, PLAIN, self.refused)
            return
        target = urlsplit(self.path)
        _, token, *rest = target.path.split("/", 2) if target.path.startswith("/") else ("", "")
        if not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self._answer(403, PLAIN, "The link needs its token; take the one that was printed.\n")
            return
        if not rest:
            self._answer(301, PLAIN, "", f"/{quote(token)}/")
            return
        try:
            page = self.server.page(rest[0], target.query)
        except (SwarmError, OSError) as error:
            self._answer(404, PLAIN, f"{error}\n")
            return
        if page is None:
            self._answer(404, PLAIN, "There is nothing here.\n")
        else:
            self._answer(200, HTML, page)

    def _answer(self, status: int, kind: str, text: str, location: str = "") -> None:
        body = text.encode()
        headers = {
            "Location": location, "Content-Type": kind, "Content-Length": str(len(body)),
            "Cache-Control": "no-cache", "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
        }  # fmt: skip
        self.send_response(status, http.HTTPStatus(status).phrase)
        for name, value in headers.items():
            if value:
                self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing: the link's token would stand in it."""

"""Who gets into the viewer: only who calls it by its own name and brings the token of the link.

With raw clients, as a browser that was led here by another page (DNS rebinding, cross-site
websockets), another program of this machine, and one that was given the link.
"""

import contextlib
import socket
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest
import viser
from websockets.sync.client import connect

from swarm_view.server.server import Server, names_of, title_of


@pytest.fixture(scope="module")
def server():
    server = Server("127.0.0.1", 0)
    server.on_pages(lambda client, robot: None, lambda client: None)
    yield server
    server.stop()


def token(server):
    return server.url().partition("token=")[2]


def status(port, target, *headers, is_websocket=False):
    """Return the status of the answer to a request; 0 if there is none."""
    upgrade = (
        ("Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
         "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==",
         f"Sec-WebSocket-Protocol: viser-v{viser.__version__}")
        if is_websocket
        else ()
    )  # fmt: skip
    request = "\r\n".join((f"GET {target} HTTP/1.1", *headers, *upgrade, "", ""))
    with socket.create_connection(("127.0.0.1", port), timeout=10.0) as link:
        link.sendall(request.encode())
        answer = link.recv(64)
    return int(answer.split()[1]) if answer else 0


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "LOCALHOST", "[::1]"])
def test_its_own_names_with_the_token(server, name):
    host, target = f"Host: {name}:{server.port}", f"/?token={token(server)}"
    origin = f"Origin: http://{name}:{server.port}"
    assert status(server.port, target, host) == 200
    assert status(server.port, target, host, origin) == 200
    assert status(server.port, target, host, origin, is_websocket=True) == 101


@pytest.mark.parametrize(
    "name",
    ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example", "10.0.0.1", "", "::1"],
)
@pytest.mark.parametrize("is_websocket", [False, True])
def test_a_name_of_somebody_else_that_leads_here(server, name, is_websocket):
    """DNS rebinding: Host and Origin agree, as the browser believes the other page's name."""
    headers = (f"Host: {name}:{server.port}", f"Origin: http://{name}:{server.port}")
    for target in ("/", f"/?token={token(server)}"):
        assert status(server.port, target, *headers, is_websocket=is_websocket) == 403


def test_other_ports_and_hosts_are_other_servers(server):
    target = f"/?token={token(server)}"
    for host in ("127.0.0.1", f"127.0.0.1:{server.port + 1}", "localhost"):
        assert status(server.port, target, f"Host: {host}") == 403
    assert "evil.example" not in names_of("0.0.0.0")
    assert {"127.0.0.1", "localhost", "[::1]", socket.gethostname()} <= names_of("0.0.0.0")
    assert "[fe80::1]" in names_of("fe80::1")
    assert names_of("10.0.0.5") == {"127.0.0.1", "localhost", "[::1]", "10.0.0.5"}


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "", "https://127.0.0.1:{port}", "http://127.0.0.1:1",
     "http://127.0.0.1:{port}.evil.example", "http://127.0.0.1:{port}@evil.example"],
)  # fmt: skip
def test_a_page_of_another_origin(server, origin):
    host = f"Host: 127.0.0.1:{server.port}"
    line = f"Origin: {origin.format(port=server.port)}"
    target = f"/?token={token(server)}"
    assert status(server.port, target, host, line, is_websocket=True) == 403
    assert status(server.port, target, host, line) == 403


@pytest.mark.parametrize(
    "query", ["", "?token=", "?token=guess", "?robot=Srobot1", "?token=%C3%A9"]
)
def test_without_the_token_there_is_nothing_to_see_nor_to_do(server, query):
    host, origin = (f"{word}127.0.0.1:{server.port}" for word in ("Host: ", "Origin: http://"))
    assert status(server.port, f"/{query}", host) == 403
    assert status(server.port, f"/{query}", host, origin, is_websocket=True) == 403


@pytest.mark.parametrize(
    "more",
    ["Host: evil.example", "Origin: http://evil.example", " Host: evil.example", "Host : a",
     "X: 1\nHost: evil.example", "Upgrade: h2c"],
)  # fmt: skip
def test_what_two_readers_could_read_in_two_ways(server, more):
    host, origin = (f"{word}127.0.0.1:{server.port}" for word in ("Host: ", "Origin: http://"))
    target = f"/?token={token(server)}"
    assert status(server.port, target, host, origin, more, is_websocket=True) in (0, 403)


@pytest.mark.parametrize("is_websocket", [False, True])
@pytest.mark.parametrize("key", ["", "X-Swarm-Key: guess"])
def test_the_inner_port_takes_only_the_gate(server, key, is_websocket):
    port = server.viser.get_port()
    headers = [f"Host: 127.0.0.1:{port}", f"Origin: http://127.0.0.1:{port}"]
    headers += [key] if key else []
    assert status(port, "/", *headers, is_websocket=is_websocket) == 403
    assert status(port, f"/?token={token(server)}", *headers, is_websocket=is_websocket) == 403


def test_who_has_the_link_gets_the_scene(server):
    link = urlsplit(server.url("Srobot1"))
    protocol = f"viser-v{viser.__version__}"
    with connect(
        f"ws://{link.netloc}/?{link.query}",
        subprotocols=[protocol],
        origin=f"http://{link.netloc}",
        max_size=None,
    ) as socket_:
        data = socket_.recv(timeout=10.0)
        assert isinstance(data, bytes)
        assert len(data) > 8


def test_every_server_has_a_token_of_its_own():
    urls = []
    for _ in range(2):
        server = Server("127.0.0.1", 0)
        urls.append(token(server))
        server.stop()
    assert urls[0] != urls[1]
    assert min(len(url) for url in urls) >= 16


def test_connections_without_a_request_end_with_the_server():
    """Browsers open some ahead; left alone they outlive the event loop as unclosed sockets."""
    server = Server("127.0.0.1", 0)
    with socket.create_connection(("127.0.0.1", server.port), timeout=5.0) as idle:
        end = time.monotonic() + 10.0
        while not server._gate._open and time.monotonic() < end:
            time.sleep(0.01)
        assert server._gate._open
        server.stop()
        assert server._gate._open == set()
        with contextlib.suppress(ConnectionResetError):
            assert idle.recv(1) == b""


def test_the_panel_names_hall_and_run():
    assert title_of("worlds/warehouse", Path("runs/first")) == "warehouse · first"
    assert title_of("/a/worlds/hall_12/world.sdf", Path("runs/first")) == "hall_12 · first"
    assert title_of("", Path("first.mcap")) == "first.mcap"

import pytest

from swarm_view.server.http_gate import PAGE, SCRIPT, parse_head, query_of


def test_a_request_is_read():
    raw = b"GET /?robot=Srobot3&token=a%20b HTTP/1.1\r\nHost: h:1\r\nUpgrade: WebSocket\r\n\r\n"
    head = parse_head(raw)
    assert head.path == "/"
    assert head.is_websocket
    assert head.query("robot") == "Srobot3"
    assert head.query("token") == "a b"
    assert head.query("none") == ""
    assert query_of("/?robot=Srobot3", "robot") == "Srobot3"


@pytest.mark.parametrize("raw", [b"POST / HTTP/1.1\r\n\r\n", b"nonsense\r\n\r\n", b"\r\n\r\n"])
def test_anything_else_is_refused(raw):
    with pytest.raises(ValueError):  # noqa: PT011
        parse_head(raw)


def test_the_page_of_this_viser_can_be_opened_on_a_robot():
    page = PAGE.read_text(encoding="utf-8")
    assert "<head>" in page
    assert "set_server" in SCRIPT

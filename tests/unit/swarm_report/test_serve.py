"""The list of runs in the browser, and who gets in."""

import http.client
import re
import threading
from urllib.parse import urlsplit

import pytest

from swarm_common.model.errors import ConfigError
from swarm_report.run_list import RunList
from swarm_report.serve import ReportServer
from tests.fakes.run_folder import make_run


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    make_run(folder / "first", robots=2, seconds=10)
    make_run(folder / "crashed <b>", robots=3, seconds=10, crash=True)
    make_run(folder / "killed", robots=2, seconds=0)
    (folder / "latest").symlink_to("first")
    (folder / "notes").mkdir()
    return folder


@pytest.fixture(scope="module")
def server(runs):
    with ReportServer(runs, 0) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.05,))
        thread.start()
        yield server
        server.shutdown()
        thread.join()


def ask(server, path, *hosts):
    """Return status and body of a request, by default with the server's own name."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    connection.putrequest("GET", path, skip_host=True)
    for host in hosts or (f"127.0.0.1:{server.server_port}",):
        connection.putheader("Host", host)
    connection.endheaders()
    response = connection.getresponse()
    body = response.read().decode()
    connection.close()
    return response.status, body


def test_runs_are_listed_and_the_newest_report_is_read(server, tmp_path):
    status, text = ask(server, f"/{server.token}/")
    assert status == 200
    assert text.count('type="checkbox"') == 3  # the link `latest` and `notes` are no runs
    assert '<td class="good">Passed</td>' in text
    assert '<td class="bad">Failed</td>' in text
    assert '<td class="open">No verdict</td>' in text
    assert 'id="search"' in text
    assert "crashed <b>" not in text
    folder = make_run(tmp_path / "a", robots=2, seconds=0)
    shown = RunList(tmp_path)
    assert [entry.cells[1] for entry in shown.entries()] == ["No verdict"]
    make_run(tmp_path / "b", robots=2, seconds=5)
    (folder / "report.json").write_bytes((tmp_path / "b" / "report.json").read_bytes())
    assert [entry.cells[1] for entry in shown.entries()] == ["Passed", "Passed"]


@pytest.mark.parametrize("name", ["first", "killed", "crashed%20%3Cb%3E"])
def test_a_run_is_shown_also_if_it_was_killed(server, name):
    status, text = ask(server, f"/{server.token}/run/{name}")
    assert (status, text[:15]) == (200, "<!DOCTYPE html>")


def test_links_lead_to_runs_whatever_their_names(tmp_path):
    """They were escaped as text, not as a link: `#` ended it, `%2f` was another name."""
    for name in ("a#1", "50%2f", "two words", "què?"):
        make_run(tmp_path / name, robots=2, seconds=1)
    with ReportServer(tmp_path, 0) as server:
        links = re.findall(r'href="(run/[^"]*)"', server.page("", "") or "")
        pages = [server.page(urlsplit(link).path, "") for link in links]
    assert len(pages) == 4
    assert None not in pages


def test_chosen_runs_are_compared(server):
    status, text = ask(server, f"/{server.token}/compare?run=first&run=killed")
    assert status == 200
    assert "2 runs compared" in text
    assert ask(server, f"/{server.token}/compare?run=first")[0] == 404


@pytest.mark.parametrize(
    "path",
    ["run/../first/report.json", "run/%2e%2e", "run//etc/passwd", "run/notes", "first", "run/x"],
)
def test_nothing_else_of_the_disk_is_shown(server, path):
    assert ask(server, f"/{server.token}/{path}")[0] == 404


@pytest.mark.parametrize("hosts", [("evil.example:{port}",), ("127.0.0.1",), ("a", "b"), ("",)])
def test_a_foreign_name_gets_nothing(server, hosts):
    named = [host.format(port=server.server_port) for host in hosts]
    status, text = ask(server, f"/{server.token}/", *named)
    assert status == 403
    assert "first" not in text


@pytest.mark.parametrize("path", ["/", "/run/first", "/wrong/", "//", "/%00/"])
def test_nobody_without_the_token_gets_anything(server, path):
    status, text = ask(server, path)
    assert status == 403
    assert "first" not in text


def test_a_port_in_use_and_a_folder_that_is_none(server, runs):
    with pytest.raises(ConfigError, match="choose another --port"):
        ReportServer(runs, server.server_port)
    with pytest.raises(ConfigError, match="is not a folder"):
        ReportServer(runs / "nowhere", 0)

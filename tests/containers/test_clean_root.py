"""The image is built and the services run, without a container engine: see fakes/hosts/containers.

Needs root, debootstrap, ip (iproute2) and a Debian mirror: `pytest tests/containers -m long`.
"""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
import yaml

from tests.fakes.hosts.containers import Builder, Image, command_in, interpolated, run
from tests.fakes.hosts.net_hosts import NetHosts

ROOT = Path(__file__).resolve().parents[2]
HOSTS = {"world": 1, "robots": 2, "viewer": 1}  # the viewer has the network of the world
LIMIT = 240.0  # [s] of wall time for a swarm of two to start, on a busy machine
pytestmark = [pytest.mark.long, pytest.mark.timeout(3600)]


@pytest.fixture(scope="module")
def image(tmp_path_factory):
    if os.geteuid() != 0 or shutil.which("debootstrap") is None:
        pytest.skip("a clean root needs root and debootstrap")
    return Builder(ROOT, tmp_path_factory.mktemp("roots")).build()


def test_the_image_has_the_commands_and_no_compiler(image):
    assert "--swarm-size" in run(image, image.command)
    assert run(image, ["id", "--user"]) == "1000\n"
    assert run(image, ["sh", "-c", "command -v gcc || echo none"]) == "none\n"
    assert "no PyBullet" not in run(image, ["swarm-up", "--list"])


def test_a_swarm_runs_in_one_container(image):
    words = ["swarm-up", "--swarm-size", "2", "--duration", "3", "--headless", "--no-report"]
    said = run(image, words)
    assert "2 of 2" in said or "all robots are active" in said


class Services:
    """The services of compose.yaml, each in the network of its host."""

    def __init__(self, image, folder, net):
        file = yaml.safe_load((ROOT / "compose.yaml").read_text("utf-8"))
        given = {"SWARM_SECRET": "of a test of containers", "SWARM_SIZE": "2"}
        self._services = interpolated(file, given)["services"]
        self._image = image
        self._folder = folder
        self.net = net
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        hosts = image.root / "etc" / "hosts"
        hosts.write_text(f"127.0.0.1 localhost\n{net.address(1)} world\n")

    def start(self, name):
        service = self._services[name]
        volume, inside = service["volumes"][0].split(":")[:2]
        place = self._folder / volume
        place.mkdir(exist_ok=True)
        os.chown(place, 1000, 1000)
        env = self._image.env | service["environment"]
        image = Image(self._image.root, self._image.workdir, self._image.user, env)
        command = command_in(image, service["command"], volumes={inside: place})
        with self.log(name).open("wb") as output:
            self.processes[name] = subprocess.Popen(
                self.net.command(HOSTS[name], *command),
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def log(self, name):
        return self._folder / f"{name}.log"

    def wait_for(self, name, pattern):
        end = time.monotonic() + LIMIT
        while not (found := re.search(pattern, self.log(name).read_text("utf-8"))):
            logs = {one: self.log(one).read_text("utf-8") for one in self.processes}
            assert time.monotonic() < end, logs
            assert self.processes[name].poll() is None, logs
            time.sleep(0.5)
        return found[0]

    def close(self):
        for pid in self.net.pids():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        for process in self.processes.values():
            process.wait(30.0)


@pytest.fixture
def services(image, tmp_path):
    with NetHosts(2) as net:
        started = Services(image, tmp_path, net)
        subprocess.run(net.command(1, "ip", "link", "set", "lo", "up"), check=True)
        subprocess.run(net.command(2, "ip", "link", "set", "lo", "up"), check=True)
        try:
            yield started
        finally:
            started.close()


def test_world_robots_and_viewer_of_the_compose_file_meet(services):
    services.start("world")
    services.start("robots")
    services.wait_for("world", r"running \| active 2/2")
    services.start("viewer")
    link = services.wait_for("viewer", r"http://\S+:8080/\?token=[\w-]+")
    token = link.partition("?")[2]
    page = f"http://127.0.0.1:8080/?{token}"
    code = "import sys, urllib.request as u; print(u.urlopen(sys.argv[1]).status)"
    asked = services.net.command(1, "python3", "-c", code, page)
    assert subprocess.run(asked, capture_output=True, text=True, check=True).stdout == "200\n"
    services.processes["world"].send_signal(signal.SIGINT)  # STOPSIGNAL
    assert services.processes["world"].wait(60.0) == 0
    assert services.processes["robots"].wait(60.0) == 0

"""One robot's connection to a real broker: will, restart, password, TLS."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time

import paho.mqtt.client as mqtt
import pytest
from paho.mqtt.enums import CallbackAPIVersion

from swarm_vda5050.broker import Broker
from swarm_vda5050.link import PASSWORD, Address, BrokerEventKind, Link

PATH = os.environ["PATH"] + os.pathsep + "/usr/sbin"
LIMIT = 20.0  # [s] of wall time
pytestmark = pytest.mark.skipif(
    shutil.which("mosquitto", path=PATH) is None, reason="mosquitto is not installed"
)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def wait(is_true):
    end = time.monotonic() + LIMIT
    while not is_true():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture(params=["mosquitto", "amqtt"])
def broker(tmp_path, request, monkeypatch):
    if request.param == "amqtt":
        pytest.importorskip("amqtt")
        monkeypatch.setattr("swarm_vda5050.broker.find_mosquitto", lambda: None)
    started = Broker(free_port(), tmp_path)
    yield started
    started.stop()


def link_to(port, user="", ca=""):
    address = Address("localhost", port, user, bool(ca), ca)
    link = Link(address, ["in"], lambda: ("out", b"broken"), "Srobot1")
    link.open()
    return link


def heard_on(port):
    """Return the list to which messages on `out` are added, once the listener is subscribed."""
    heard: list[bytes] = []
    ready: list[int] = []
    client = mqtt.Client(CallbackAPIVersion.VERSION2)
    client.on_message = lambda _client, _data, message: heard.append(message.payload)
    client.on_subscribe = lambda *_: ready.append(1)
    client.connect("localhost", port)
    client.subscribe("out")
    client.loop_start()
    wait(lambda: bool(ready))
    return heard


def test_a_cut_link_leaves_its_will_and_a_closed_one_a_goodbye(broker):
    heard = heard_on(broker.port)
    link = link_to(broker.port)
    wait(lambda: link.is_open)
    link.publish("out", b"hello")
    wait(lambda: heard == [b"hello"])
    link.cut()
    wait(lambda: heard == [b"hello", b"broken"])
    link.open()
    wait(lambda: link.is_open)
    link.close("out", b"bye")
    wait(lambda: heard == [b"hello", b"broken", b"bye"])


def test_a_link_outlives_its_broker(broker):
    link = link_to(broker.port)
    wait(lambda: not link.inbox.empty())
    assert link.inbox.get().kind is BrokerEventKind.CONNECTED
    broker.stop()
    wait(lambda: not link.is_open)
    assert broker.revive()
    assert not broker.revive()
    wait(lambda: not link.inbox.empty() and link.inbox.get().kind is BrokerEventKind.CONNECTED)
    link.close("out", b"bye")


def test_users_are_known_by_password_and_brokers_by_certificate(tmp_path, monkeypatch):
    key, certificate, port = tmp_path / "key.pem", tmp_path / "ca.pem", free_port()
    subprocess.run(
        ("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2",
         "-keyout", key, "-out", certificate, "-subj", "/CN=localhost",
         "-addext", "subjectAltName=DNS:localhost"),
        check=True, capture_output=True,
    )  # fmt: skip
    words = tmp_path / "words"
    subprocess.run(("mosquitto_passwd", "-b", "-c", words, "fleet", "right"), check=True)
    config = tmp_path / "tls.conf"
    config.write_text(
        f"listener {port} 127.0.0.1\ncertfile {certificate}\nkeyfile {key}\n"
        f"allow_anonymous false\npassword_file {words}\nuser root\n",
        encoding="utf-8",
    )
    program = str(shutil.which("mosquitto", path=PATH))
    with subprocess.Popen((program, "-c", config), stderr=subprocess.DEVNULL) as process:
        try:
            for password, expected in (
                ("wrong", BrokerEventKind.REFUSED),
                ("right", BrokerEventKind.CONNECTED),
            ):
                monkeypatch.setenv(PASSWORD, password)
                link = link_to(port, "fleet", str(certificate))
                seen: list[BrokerEventKind] = []

                def is_told(link=link, seen=seen):
                    while not link.inbox.empty():
                        arrival = link.inbox.get()
                        if arrival.payload != b"nobody answers":
                            seen.append(arrival.kind)
                    return bool(seen)

                wait(is_told)
                assert seen[0] is expected
                link.close("out", b"bye")
        finally:
            process.terminate()


def test_the_broker_ends_with_whoever_started_it(tmp_path):
    """As root it went over to another user, and lived on when its starter was killed."""
    port = free_port()
    code = "import os, pathlib, sys; from swarm_vda5050.broker import Broker; "
    code += "Broker(int(sys.argv[1]), pathlib.Path(sys.argv[2])); os.kill(os.getpid(), 9)"
    ended = subprocess.run((sys.executable, "-c", code, str(port), str(tmp_path)), check=False)
    assert ended.returncode == -signal.SIGKILL

    def is_gone():
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) != 0

    wait(is_gone)

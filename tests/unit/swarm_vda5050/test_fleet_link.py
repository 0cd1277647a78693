"""Options of swarm-up for a fleet control."""

import socket
from pathlib import Path

import pytest

from swarm_common.model.central import Coordination
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_nav.core.plugins import RULE_NAMES
from swarm_run.fleet_link import FAULTS, VERSIONS, FleetLink, find_mosquitto, fleet_link
from swarm_run.plan import FLEET_RULES, check_plan
from swarm_run.spec import RunSpec
from swarm_vda5050 import standard
from swarm_vda5050.simulated_faults import SIMULATED


def test_addresses_are_read():
    assert FleetLink(url="mqtt://localhost").config()["broker"]["port"] == 1883
    assert FleetLink(url="embedded:1900").config()["broker"]["port"] == 1900
    assert FleetLink(url="embedded").config()["embedded"]
    link = FleetLink(url="mqtts://broker.example", user="fleet", version="3.0")
    broker = link.config()["broker"]
    assert (broker["host"], broker["port"], broker["is_secure"]) == ("broker.example", 8883, True)
    assert fleet_link(None, None) is None


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"url": "http://localhost"}, "expected mqtt://"),
        ({"url": "mqtt://"}, "expected mqtt://"),
        ({"url": "mqtt://localhost:99999"}, "expected mqtt://"),
        ({"url": "mqtt://me:secret@localhost"}, "expected mqtt://"),
        ({"url": "embedded:x"}, "expected mqtt://"),
        ({"url": "embedded:0"}, "expected mqtt://"),
        ({"url": "mqtt://192.0.2.1"}, "--vda5050-user"),
        ({"url": "embedded", "version": "1.1"}, "did you mean '2.1'"),
        ({"url": "embedded", "manufacturer": "a/b"}, "--manufacturer"),
        ({"url": "embedded", "interface": "a/b"}, "--vda5050-interface"),
        ({"url": "embedded", "check": "strikt"}, "did you mean 'strict'"),
        ({"url": "embedded", "faults": ({"robot": "a"},)}, "expected at"),
        (
            {"url": "embedded", "faults": ({"at": 1, "robot": "a", "fault": "simErorr"},)},
            "did you mean 'simError'",
        ),
        ({"url": "embedded", "ca": Path("none.pem")}, "no file"),
        ({"url": "embedded", "ca": Path(__file__)}, "mqtts://"),
    ],
)
def test_what_makes_no_sense_is_refused(given, word):
    with pytest.raises(ConfigError, match=word):
        FleetLink(**given)


def test_the_options_know_the_versions_of_the_standard():
    assert tuple(standard.VERSIONS) == VERSIONS
    assert tuple(SIMULATED) == FAULTS


def test_a_port_or_broker_that_cannot_be_used_is_named(monkeypatch):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(ConfigError, match=f"cannot use port {port}"):
            fleet_link(f"embedded:{port}", None)
    monkeypatch.setattr("shutil.which", lambda *_, **__: None)
    monkeypatch.setattr("importlib.util.find_spec", lambda _: object())
    assert find_mosquitto() is None
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(ConfigError, match="apt-get install mosquitto"):
        FleetLink(url="embedded")


def test_a_fleet_control_alone_coordinates_robots_without_their_own_rules():
    assert set(FLEET_RULES.split()) == {*RULE_NAMES} - {"make_way", "leave", "wait"}
    led = {"coordination": Coordination.FLEET, "vda5050": "embedded"}
    for more, rules in (({}, "all"), (led, FLEET_RULES)):
        plan = check_plan(RunSpec(world="hall_12", **more))
        (parameters,) = plan.parameter_file(1, Pose(0.0, 0.0, 0.0)).values()
        assert parameters["ros__parameters"]["traffic"]["rules"] == rules

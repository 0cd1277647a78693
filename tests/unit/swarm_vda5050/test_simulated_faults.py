"""Faults on demand: what the robot reports and does meanwhile, and that it goes on afterwards."""

import pytest

from swarm_vda5050.messages import OrderAction, Parameter
from swarm_vda5050.simulated_faults import SIMULATED
from tests.fakes.fleet_orders import OF_2, OF_3, Toy, action, along, node, order
from tests.unit.swarm_vda5050.test_zones import toy_with, zone


def errors(toy):
    written = [toy.dialect.error(report) for report in toy.vehicle.errors]
    return [(each.error_type, each.error_level) for each in written]


@pytest.mark.parametrize("kind", ["simEmergencyStop", "simLoseLocation", "simError"])
def test_a_robot_stands_while_it_must_not_drive_and_then_goes_on(kind):
    toy = Toy()
    toy.send(along(0, 3, 3))
    toy.step()
    error = {"errorType": "fire", "errorLevel": "FATAL"}
    more = {"simEmergencyStop": {"type": "MANUAL"}, "simError": error}
    toy.do(kind, "f", duration=10.0, **more.get(kind, {}))
    toy.wait(1.0)
    assert toy.vehicle.leg is None
    assert toy.vehicle.node_states
    if kind != "simEmergencyStop":
        name = "fire" if kind == "simError" else "localizationError"
        assert errors(toy) == [(name, "FATAL")]
    toy.wait(10.0)
    assert errors(toy) == []
    toy.drive()
    assert toy.vehicle.last_node == ("n3", 6)


@pytest.mark.parametrize(("identity", "last"), [(OF_2, "n0"), (OF_3, "")])
def test_modes_end_the_order_or_let_it_go_on(identity, last):
    toy = Toy(identity)
    toy.send(along(0, 3, 3))
    toy.do("simOperatingMode", "a", mode="SEMIAUTOMATIC")
    toy.wait(0.1)
    assert (toy.vehicle.operating_mode, toy.vehicle.is_busy) == ("SEMIAUTOMATIC", True)
    toy.do("simOperatingMode", "b", mode="SERVICE", duration=5.0)
    toy.wait(0.1)
    assert (toy.vehicle.operating_mode, toy.vehicle.is_busy) == ("SERVICE", False)
    toy.send(along(0, 1, 1, "B"))
    assert "NOT_AVAILABLE" in toy.faults
    assert toy.vehicle.last_node[0] == last
    toy.wait(9.0)
    assert "NOT_AVAILABLE" not in toy.faults
    toy.send(along(0, 1, 1, "B"))
    toy.drive()
    assert toy.vehicle.last_node == ("n1", 2)


def test_who_is_intervened_keeps_its_order_takes_updates_and_asks_for_nothing():
    toy = toy_with(zone("RELEASE", 3.0, 5.0))
    toy.send(along(0, 2, 4))
    toy.wait(0.1)
    toy.do("simOperatingMode", "a", mode="INTERVENED", duration=9.0)
    toy.wait(0.1)
    assert (toy.vehicle.operating_mode, toy.vehicle.is_busy) == ("INTERVENED", True)
    assert toy.vehicle.leg is None
    assert toy.vehicle.zones.requests == ()
    toy.send(along(2, 4, 4, update=1))
    assert (toy.vehicle.order_update_id, toy.faults) == (1, [])
    toy.do("startPause", "p")
    assert (toy.done["p"], toy.faults) == ("FAILED", ["INSTANT"])
    toy.wait(10.0)
    assert len(toy.vehicle.zones.requests) == 1
    assert toy.vehicle.leg is not None
    toy.do("simOperatingMode", "b", mode="INTERVENED")
    toy.do("cancelOrder", "c")
    toy.wait(0.1)
    assert (toy.done["c"], toy.vehicle.is_busy) == ("FINISHED", False)


def test_one_action_fails_and_one_order_is_not_answered():
    toy = Toy()
    toy.do("simFailAction", "f", actionType="pick")
    toy.send(order([node(0, action("wait", "w", duration=1.0), action("pick", "p"))]))
    toy.wait(1.0)
    toy.wait(6.0)
    assert toy.done == {"w": "FINISHED", "p": "FAILED"}
    assert toy.faults == ["ACTION"]
    toy.do("simIgnoreOrder", "g")
    toy.send(along(0, 1, 1, "B"))
    assert (toy.vehicle.order_id, toy.faults) == ("A", ["ACTION"])
    toy.send(along(0, 1, 1, "B"))
    assert toy.vehicle.order_id == "B"


def test_battery_connection_and_states_are_pretended_until_the_end():
    toy = Toy()
    toy.do("simBattery", "b", charge=7.0)
    toy.do("simBreakConnection", "c", duration=5.0)
    toy.do("simSlowState", "s", period=9.0)
    simulated = toy.vehicle.simulated
    assert (simulated.charge, simulated.is_cut, simulated.state_period) == (7.0, True, 9.0)
    toy.wait(6.0)
    assert (simulated.charge, simulated.is_cut) == (7.0, False)
    toy.do("simEnd", "e")
    assert (simulated.charge, simulated.state_period) == (None, 0.0)


@pytest.mark.parametrize(
    ("kind", "parameters", "word"),
    [
        ("simOperatingMode", {"mode": "FLYING"}, "AUTOMATIC, SEMIAUTOMATIC"),
        ("simEmergencyStop", {"type": "LOUD"}, "AUTOACK"),
        ("simError", {"errorType": "x", "errorLevel": "BAD"}, "CRITICAL"),
        ("simBattery", {"charge": 101.0}, "0 to 100"),
        ("simBreakConnection", {}, "lacks the parameter 'duration'"),
    ],
)
def test_a_fault_that_makes_no_sense_is_refused(kind, parameters, word):
    toy = Toy()
    toy.do(kind, "f", **parameters)
    assert toy.faults == ["INSTANT"]
    assert word in toy.vehicle.errors[0].message


def test_levels_are_those_of_the_version_and_all_faults_are_in_the_factsheet():
    for identity, level in ((OF_2, "FATAL"), (OF_3, "CRITICAL")):
        toy = Toy(identity)
        toy.do("simError", "f", errorType="hot", errorLevel="CRITICAL")
        assert errors(toy) == [("hot", level)]
        assert set(SIMULATED) <= set(identity.offered)


def test_faults_of_a_file_begin_at_their_time():
    toy = Toy()
    charge = Parameter(key="charge", value=5.0)
    fault = OrderAction(action_type="simBattery", action_id="t", action_parameters=(charge,))
    toy.vehicle.plan_faults([(30.0, fault)])
    toy.wait(29.0)
    assert toy.vehicle.simulated.charge is None
    toy.wait(1.0)
    assert toy.vehicle.simulated.charge == 5.0

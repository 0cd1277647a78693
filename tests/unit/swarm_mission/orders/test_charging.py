"""A robot that goes to charge does not bid, and gives back what it has not loaded."""

import math

import pytest

from swarm_common.model.records import Pose
from swarm_mission.orders.courier import Courier
from swarm_mission.orders.messages import (
    Announcement,
    Bid,
    Grant,
    HoldPhase,
    HoldReport,
    OrderOffer,
)
from swarm_mission.orders.order import TransportOrder
from swarm_mission.orders.robot_bidder import BidSenses
from swarm_mission.orders.states import CourierState

STATIONS = {"a": Pose(10.0, 0.0, 0.0), "b": Pose(20.0, 0.0, 0.0)}
ORDER = TransportOrder("1-1", "a", "b", 0, 10, 10)
OFFERS = Announcement("a", (OrderOffer("1-1", "b", 0),))


def senses(reach):
    return BidSenses(lambda _: 10.0, 0.5, lambda: 0.5, lambda: reach, way_between=lambda *_: 10.0)


def bids(courier, reach):
    courier.receive(OFFERS, 1)
    sent, _ = courier.tick(1, senses(reach))
    return [each.message for each in sent if isinstance(each.message, Bid)]


@pytest.mark.parametrize("bids_for_all", [False, True])
@pytest.mark.parametrize(("reach", "count"), [(math.inf, 1), (20.0, 1), (19.9, 0), (0.0, 0)])
def test_who_would_have_to_charge_before_the_end_does_not_bid(reach, count, *, bids_for_all):
    courier = Courier("r", Pose(0.0, 0.0, 0.0), STATIONS, bids_for_all=bids_for_all)
    assert len(bids(courier, reach)) == count


def test_an_order_is_given_back_on_the_way_to_its_origin():
    courier = Courier("r", Pose(0.0, 0.0, 0.0), STATIONS)
    courier.receive(Grant("a", "r", ORDER, 1), 1)
    _, goal = courier.tick(1, senses(math.inf))
    assert goal.stop.name == "a"
    sent, goal = courier.tick(2, senses(0.0))
    reports = [each.message for each in sent if isinstance(each.message, HoldReport)]
    assert [report.phase for report in reports] == [HoldPhase.RELEASED]
    assert courier.state is CourierState.PARKING
    assert goal is not None


def test_goods_are_kept_while_the_robot_is_charged():
    courier = Courier("r", Pose(0.0, 0.0, 0.0), STATIONS)
    courier.receive(Grant("a", "r", ORDER, 1), 1)
    courier.tick(1, senses(math.inf))
    courier.bidder.held["1-1"].phase = HoldPhase.LOADED
    courier.tick(2, senses(0.0))
    assert list(courier.bidder.held) == ["1-1"]

"""Tables of orders and couriers: every pair that is not in them raises."""

import pytest

from swarm_mission.orders.states import (
    COURIER_TRANSITIONS,
    ORDER_TRANSITIONS,
    CourierState,
    OrderChange,
    OrderState,
)


def test_every_state_has_its_row():
    assert set(ORDER_TRANSITIONS) == set(OrderState)
    assert set(COURIER_TRANSITIONS) == set(CourierState)


@pytest.mark.parametrize("state", OrderState)
@pytest.mark.parametrize("change", OrderChange)
def test_an_order_is_granted_from_open_and_loaded_from_granted_only(state, change):
    row = ORDER_TRANSITIONS[state]
    assert (change in row) == (
        change is OrderChange.DELIVERED
        or (change is OrderChange.GRANT and state is OrderState.OPEN)
        or (change is OrderChange.LOAD and state is OrderState.GRANTED)
        or (change is OrderChange.TAKE_BACK and state in (OrderState.GRANTED, OrderState.LOADED))
    )
    assert row.get(change) is not state or state is OrderState.DONE

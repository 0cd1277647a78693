"""States of an order at its station, and of a robot with its orders, as tables."""

from __future__ import annotations

from enum import Enum


class OrderState(Enum):
    """Where an order is, as its origin knows it."""

    OPEN = "open"
    GRANTED = "granted"  # to a robot, which is on its way
    LOADED = "loaded"  # handed over
    DONE = "done"


class OrderChange(Enum):
    """Change of an order's state."""

    GRANT = "grant"
    LOAD = "load"
    TAKE_BACK = "take back"  # the robot is dead, mute or late, or gave it back
    DELIVERED = "delivered"  # as the target says


ORDER_TRANSITIONS: dict[OrderState, dict[OrderChange, OrderState]] = {
    OrderState.OPEN: {
        OrderChange.GRANT: OrderState.GRANTED,
        OrderChange.DELIVERED: OrderState.DONE,  # by a robot that it was taken back from
    },
    OrderState.GRANTED: {
        OrderChange.LOAD: OrderState.LOADED,
        OrderChange.TAKE_BACK: OrderState.OPEN,
        OrderChange.DELIVERED: OrderState.DONE,
    },
    OrderState.LOADED: {
        OrderChange.TAKE_BACK: OrderState.OPEN,
        OrderChange.DELIVERED: OrderState.DONE,
    },
    OrderState.DONE: {OrderChange.DELIVERED: OrderState.DONE},
}


class CourierState(Enum):
    """State of a robot with its orders."""

    IDLE = "idle"
    PARKING = "parking"  # on its way home, without orders
    DRIVING = "driving"  # to a station
    ASKING = "asking"  # at a station, to be loaded or unloaded
    SERVED = "served"  # loaded or unloaded


class CourierEvent(Enum):
    """Event in the work of a robot with its orders."""

    STOP = "stop"  # there is a station to go to
    HOME = "home"  # there is none
    REACHED = "reached"
    MISSED = "missed"
    SERVICE = "service"
    SERVICE_OVER = "service over"


COURIER_TRANSITIONS: dict[CourierState, dict[CourierEvent, CourierState]] = {
    CourierState.IDLE: {
        CourierEvent.STOP: CourierState.DRIVING,
        CourierEvent.HOME: CourierState.PARKING,
    },
    CourierState.PARKING: {
        CourierEvent.STOP: CourierState.DRIVING,
        CourierEvent.REACHED: CourierState.IDLE,
        CourierEvent.MISSED: CourierState.IDLE,
    },
    CourierState.DRIVING: {
        CourierEvent.STOP: CourierState.DRIVING,
        CourierEvent.HOME: CourierState.PARKING,
        CourierEvent.REACHED: CourierState.ASKING,
        CourierEvent.MISSED: CourierState.DRIVING,
    },
    CourierState.ASKING: {
        CourierEvent.STOP: CourierState.DRIVING,
        CourierEvent.HOME: CourierState.PARKING,
        CourierEvent.SERVICE: CourierState.SERVED,
    },
    CourierState.SERVED: {
        CourierEvent.STOP: CourierState.DRIVING,
        CourierEvent.HOME: CourierState.PARKING,
        CourierEvent.SERVICE_OVER: CourierState.IDLE,
    },
}

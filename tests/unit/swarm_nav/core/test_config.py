"""Parameters: their names, their checks and what a message about a bad one says."""

import pytest

from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_nav.core.config import NavConfig, config_from_parameters, parameter_values


def test_parameters_survive_a_round_trip_and_a_change_keeps_the_others():
    values = parameter_values(NavConfig())
    assert config_from_parameters(values) == NavConfig()
    assert values["max_vel_x"] == 0.26
    assert values["goal_checker.xy_goal_tolerance"] == 0.25
    assert [name for name in values if name.startswith("controller.")] == ["controller.plugin"]
    base = config_from_parameters({"max_vel_x": 0.15})
    changed = config_from_parameters({"holding.mode": "park"}, base)
    assert changed.controller.max_vel_x == 0.15
    assert changed.holding.mode == "park"
    assert changed.traffic == NavConfig().traffic
    config = config_from_parameters({"acc_lim_x": 2})
    assert config.controller.acc_lim_x == 2.0
    assert isinstance(config.controller.acc_lim_x, float)


@pytest.mark.parametrize(
    ("name", "closest"),
    [
        ("goal_checker.xy_goal_tolerence", "goal_checker.xy_goal_tolerance"),
        ("holding.modes", "holding.mode"),
    ],
)
def test_an_unknown_name_is_answered_with_the_closest_one(name, closest):
    with pytest.raises(UnknownNameError, match=f"unknown parameter '{name}' in x.yaml") as error:
        config_from_parameters({name: 1.0}, where="x.yaml")
    assert f"'{closest}'" in str(error.value)
    assert error.value.name == name


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("max_vel_x", "fast", "expected a number"),
        ("vx_samples", 8.0, "expected an integer"),
        ("planner.allow_unknown", 1, "expected true or false"),
    ],
)
def test_a_wrong_type_is_named(name, value, expected):
    with pytest.raises(ConfigError, match=expected) as error:
        config_from_parameters({name: value}, where="x.yaml")
    assert f"'{name}' in x.yaml is {value!r}" in str(error.value)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("max_vel_x", 0.0),
        ("sim_time", 0.0),
        ("vx_samples", 1),
        ("vtheta_samples", 101),
        ("costmap.footprint_padding", -0.01),
        ("traffic.safety_margin", 0.0),
        ("traffic.held_length", 0.05),
        ("traffic.held_length", 0.9),
        ("traffic.wanted_length", 0.5),
        ("traffic.confirmations", 0),
        ("holding.mode", "circle"),
    ],
)
def test_an_impossible_value_is_refused_with_its_name(name, value):
    with pytest.raises(ConfigError, match=name.replace(".", r"\.")):
        config_from_parameters({name: value})


@pytest.mark.parametrize("name", ["sim_time", "costmap.local_size"])
def test_a_value_that_would_exhaust_the_memory_is_refused(name):
    with pytest.raises(ConfigError, match=name.replace(".", r"\.")):
        config_from_parameters({name: 1e7})

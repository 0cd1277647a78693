"""Every number among the parameters has limits, and within them nothing is endless."""

import copy
import math

import pytest

from swarm_common.model.errors import ConfigError
from swarm_nav.core import limits
from swarm_nav.core.config import NavConfig, config_from_parameters, parameter_values
from swarm_nav.core.parameter_table import parameter_table

NUMBERS = {
    name: value
    for name, value in parameter_values(NavConfig()).items()
    if not isinstance(value, (bool, str))
}


@pytest.mark.parametrize("name", sorted(NUMBERS))
def test_no_parameter_may_be_absurd(name):
    """`costmap.scan_timeout` of 1e308 s ended the navigator at b11a34e."""
    kind = type(NUMBERS[name])
    for value in (1e308, -1e308, 1e17) if kind is float else (2**62, -(2**62)):
        with pytest.raises(ConfigError, match=name.rpartition(".")[2]):
            config_from_parameters({name: kind(value)})
    if kind is float:
        for value in (math.nan, math.inf):
            with pytest.raises(ConfigError):
                config_from_parameters({name: value})


def test_every_rule_is_of_a_parameter_and_has_its_default_within():
    for name, interval in limits.RANGES.items():
        assert NUMBERS[name] in interval


@pytest.mark.parametrize("name", [row.name for row in parameter_table().values() if row.is_number])
def test_a_range_names_no_end_that_is_refused(name):
    """`max_vel_x is 51; it must be from 0 to 50`, and then 0 was refused."""
    row = parameter_table()[name]
    group = copy.copy(getattr(NavConfig(), row.group))
    object.__setattr__(group, name.rpartition(".")[2], row.high + 1)  # past its own checks
    with pytest.raises(ConfigError) as caught:
        limits.check(group)
    said = str(caught.value)
    assert (f"more than {row.low:.10g}" in said) == row.excludes_low
    assert (f"less than {row.high:.10g}" in said) == row.excludes_high

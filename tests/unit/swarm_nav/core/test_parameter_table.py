"""The table of parameters tells what is accepted, and says something about each."""

import math
import re

import pytest

from swarm_common.model.errors import ConfigError
from swarm_nav.core.config import config_from_parameters
from swarm_nav.core.parameter_table import parameter_table, unit_and_effect

ROWS = parameter_table()
NUMBERS = [pytest.param(row, id=row.name) for row in ROWS.values() if row.is_number]
# Bounds of one that depend on another one: set together.
PAIRS = {"localisation.min_particles": "localisation.max_particles"}
PAIRS |= {high: low for low, high in PAIRS.items()}
# One must be less than the other, which is set to its own end.
BESIDE = {"battery.low": {"battery.enough": 1.0}, "battery.enough": {"battery.low": 0.0}}


def accepts(row, value):
    names = [row.name, *([PAIRS[row.name]] if row.name in PAIRS else [])]
    try:
        values = {name: type(row.default)(value) for name in names}
        config_from_parameters(values | BESIDE.get(row.name, {}))
    except ConfigError:
        return False
    return True


@pytest.mark.parametrize("row", NUMBERS)
def test_the_range_is_what_is_accepted_and_told(row):
    is_whole = isinstance(row.default, int)
    below = row.low - 1 if is_whole else math.nextafter(row.low, -math.inf)
    above = row.high + 1 if is_whole else math.nextafter(row.high, math.inf)
    assert not accepts(row, below)
    assert not accepts(row, above)
    assert accepts(row, row.low) == (not row.excludes_low)
    assert accepts(row, row.high) == (not row.excludes_high)
    if row.excludes_low:
        assert accepts(row, row.low + 1e-3)
    if row.excludes_high:
        assert accepts(row, row.high - 1e-3)
    # `holding.region_density` of 1e308 was told to be from -10000.
    value = 2**62 if isinstance(row.default, int) else 1e308
    with pytest.raises(ConfigError) as caught:
        config_from_parameters({row.name: value})
    named = re.search(r"from (\S+) to (\S+)$", str(caught.value))
    if named is not None:  # some have a limit by another one
        assert (float(named[1]), float(named[2])) == (row.low, row.high)
    assert "-" not in str(caught.value)


def test_a_range_has_unit_choices_and_constraints():
    for row in ROWS.values():
        if isinstance(row.default, str) and not row.name.endswith(("plugin", "rules")):  # own
            assert row.default in row.choices
            for choice in row.choices:
                config_from_parameters({row.name: choice})
    assert ROWS["holding.mode"].choices == ("circuit", "park", "auto")
    assert ROWS["costmap.cost_scaling_factor"].constraint == "more than 0"
    assert ROWS["localisation.pf_z"].constraint == "less than 1"
    assert ROWS["localisation.type"].constraint == "one of odometry, amcl"
    assert ROWS["max_vel_y"].constraint == ""
    assert ROWS["max_vel_x"].description == "largest speed forwards [m/s]"
    assert unit_and_effect("[m/s²] of that") == ("m/s²", "of that")
    assert unit_and_effect("variance [rad²] of a turn") == ("", "variance [rad²] of a turn")

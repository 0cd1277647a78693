from itertools import combinations

import numpy as np

from swarm_commander.run.results.status_table import MARKS
from swarm_common.model.palette import LOOKS, STATES, css
from swarm_report import style

ENUMERATED = "inactive, idle, driving, holding, yielding, waiting, pausing, charging, recovering"


def test_every_state_has_looks_of_its_own_everywhere_the_same():
    assert set(ENUMERATED.split(", ")) <= set(LOOKS)
    assert len({look.letter for look in LOOKS.values()}) == len(LOOKS)
    assert len({look.meaning for look in LOOKS.values()}) == len(LOOKS)
    for one, other in combinations(STATES.values(), 2):
        assert np.abs(np.subtract(one, other)).sum() > 60
    assert {state: css(color) for state, color in STATES.items()} == style.STATES
    for state in ("driving", "holding", "waiting", "yielding", "recovering", "pausing"):
        assert MARKS[state] == (LOOKS[state].letter, css(LOOKS[state].color))

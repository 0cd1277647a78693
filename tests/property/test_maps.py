"""Property: in random maps with slanted walls and doors nobody touches, and held tubes keep apart.

Whatever the radio loses or delays and whoever dies. Where nobody dies, all reach all their goals:
every two places of these maps are joined by ways around, so that there is room to make way.
"""

import functools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from swarm_run.loop import InjectedFaults
from swarm_sim.maps.draw_map import draw_world
from tests.fakes.party import Party, bars_of_room, draw_places, scene_of

STEADY = dict(
    deadline=None,
    derandomize=True,
    phases=(Phase.explicit, Phase.generate),
    suppress_health_check=[HealthCheck.too_slow],
)


@dataclass(frozen=True)
class Map:
    """A hall with a slanted wall across it, in which there are two doors, and a slanted block.

    Attributes:
        seed: Of sizes, places and goals.
        robots: How many.
        doors: Widths [m].
        tilt: [rad] of wall and block.
        loss: Share of the beacons that are lost.
        delay: [s] that beacons are late.
        death: Tick from which the first robot does and says nothing; None for never.
    """

    seed: int
    robots: int
    doors: tuple[float, float]
    tilt: float
    loss: float = 0.0
    delay: float = 0.0
    death: int | None = None

    @functools.cached_property
    def party(self):
        rng = np.random.default_rng(self.seed)
        width, height = map(float, rng.uniform((7.0, 6.0), (9.0, 7.5)))
        bars = bars_of_room(width, height)
        along = np.array((math.sin(self.tilt), math.cos(self.tilt)))
        middle = np.array((width, height)) / 2
        first, second = self.doors
        inner = rng.uniform(1.5, 2.2)  # length of the wall between the doors
        reach = height / 2 / math.cos(self.tilt)
        for start, end in (
            (-reach, -inner / 2 - first),
            (-inner / 2, inner / 2),
            (inner / 2 + second, reach),
        ):
            x, y = middle + (start + end) / 2 * along
            bars.append((x, y, end - start, 0.15, math.pi / 2 - self.tilt))
        x, y = rng.uniform((1.5, 1.5), (2.5, height - 1.5))
        bars.append((x, y, *rng.uniform(0.2, 0.8, 2), float(rng.uniform(0.0, math.pi))))
        return self._party([tuple(map(float, bar)) for bar in bars], (width, height), rng)

    def _party(self, bars, size, rng):
        grid = draw_world(scene_of(bars))
        homes, *goals = (draw_places(grid, size, rng, self.robots) for _ in range(3))
        return Party(
            bars=bars, homes=homes, goals=list(zip(*goals, strict=True)), seed=self.seed,
            loss=self.loss, delay=self.delay, limit=400.0,
        )  # fmt: skip

    def run(self):
        faults = None if self.death is None else InjectedFaults(dead={0: self.death})
        return self.party.run(faults=faults)


maps = st.builds(
    Map,
    seed=st.integers(0, 2**20),
    robots=st.integers(2, 6),
    doors=st.tuples(st.sampled_from((0.8, 1.0, 1.3)), st.sampled_from((0.8, 1.2, 1.6))),
    tilt=st.sampled_from((0.0, 0.15, -0.35)),
    loss=st.sampled_from((0.0, 0.2, 0.4)),
    delay=st.sampled_from((0.0, 0.1, 0.2)),
)
deadly = st.builds(
    Map,
    seed=st.integers(0, 2**20),
    robots=st.integers(3, 6),
    doors=st.just((1.0, 1.3)),
    tilt=st.sampled_from((0.0, 0.25)),
    loss=st.sampled_from((0.0, 0.2)),
    delay=st.sampled_from((0.0, 0.2)),
    death=st.integers(10, 250),
)


def check_is_safe(result):
    assert (result.robot_robot, result.robot_world) == (0, 0), result.first_collision
    assert result.keeps_apart, result.breach


@settings(max_examples=5, **STEADY)
@given(maps)
def test_all_reach_all_goals_in_any_map(drawn):
    result = drawn.run()
    check_is_safe(result)
    assert result.is_flawless, (drawn, result)


@settings(max_examples=4, **STEADY)
@given(deadly)
def test_nobody_touches_anything_in_any_map_when_a_robot_dies(drawn):
    drawn.party.limit = 90.0
    check_is_safe(drawn.run())


@pytest.mark.long
@pytest.mark.timeout(7200)
@settings(max_examples=200, **STEADY)
@given(st.one_of(maps, deadly))
def test_hundreds_of_maps(drawn):
    result = drawn.run()
    check_is_safe(result)
    assert result.is_flawless or drawn.death is not None, (drawn, result)

"""Two rooms with a door between them, and robots that are to change rooms."""

import math

import numpy as np

from swarm_sim.maps.draw_map import draw_world
from tests.fakes.party import Bar, Party, bars_of_room, draw_places, scene_of

WIDTH, DEPTH, DOOR = 8.0, 4.4, 0.7  # [m]
THICK = 0.15  # [m]


def party(seed: int, each: int, *, tilt: float = 0.0, limit: float = 300.0) -> Party:
    """Return two rooms with as many robots each, which are to change sides."""
    rng = np.random.default_rng(seed)
    middle, half = DEPTH * rng.uniform(0.3, 0.7), DOOR / 2
    bars: list[Bar] = bars_of_room(WIDTH, DEPTH)
    for end, sign in ((-0.5, -1.0), (DEPTH + 0.5, 1.0)):
        inner = middle + sign * half
        length, y = abs(end - inner), (end + inner) / 2
        x = WIDTH / 2 - (y - middle) * math.tan(tilt)
        bars.append((x, y, THICK, length, tilt))
    grid = draw_world(scene_of(bars))
    sides = ((0.0, 0.4 * WIDTH), (0.6 * WIDTH, WIDTH))
    homes = [draw_places(grid, (WIDTH, DEPTH), rng, each, side) for side in sides]
    goals = [draw_places(grid, (WIDTH, DEPTH), rng, each, side) for side in reversed(sides)]
    return Party(
        bars=bars, homes=[*homes[0], *homes[1]], goals=[(p,) for p in (*goals[0], *goals[1])],
        seed=seed, loss=0.2 * (seed % 2), limit=limit,
    )  # fmt: skip

"""A hall with a blind aisle at whose end there is a station that everybody wants."""

import itertools
import math

from swarm_bench.runs.harness import Watcher
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_nav.behaviour.navigator import Navigator
from swarm_nav.traffic.gate import label_of
from tests.fakes.party import Bar, Party, bars_of_room

WIDTH, DEPTH = 22.0, 7.0  # the aisle is large enough for a gate
MOUTH = 6.0  # x [m] where the aisle begins; it ends at the far wall
AISLE = (2.6, 4.4)  # y [m] from and to
DOCK = Pose(WIDTH - 1.5, 3.5, math.pi / 2)
_MIDDLE, _LENGTH = (MOUTH + WIDTH) / 2, WIDTH - MOUTH
BARS: list[Bar] = [
    *bars_of_room(WIDTH, DEPTH),
    (_MIDDLE, AISLE[0] / 2, _LENGTH, AISLE[0], 0.0),
    (_MIDDLE, (AISLE[1] + DEPTH) / 2, _LENGTH, DEPTH - AISLE[1], 0.0),
]
HOMES = [
    Pose(0.8 + 1.1 * column, 0.8 + 1.1 * row, 0.0)
    for row, column in itertools.product(range(3), range(4))
]


def party(seed: int, count: int = len(HOMES), limit: float = 600.0, **changes: float) -> Party:
    return Party(
        bars=BARS, homes=HOMES[:count], goals=[(DOCK, home) for home in HOMES[:count]], seed=seed,
        sites=Sites(stations={"dock": DOCK}), loss=0.2 * (seed % 2), limit=limit, changes=changes,
    )  # fmt: skip


class Census:
    """Watches a gate: how many are inside, who has waited at it, and whether all got in."""

    def __init__(self) -> None:
        self.most = 0
        self.entered: set[int] = set()
        self.waited: dict[int, int] = {}

    def watch(self) -> Watcher:
        def look(world: object, robots: list[Navigator], outputs: object) -> None:
            inside = set()
            for index, robot in enumerate(robots):
                gate, frame = robot._gate, robot._s.planner.lattice.frame
                assert gate.region is not None
                if label_of(gate.region, frame, robot.pose_map.x, robot.pose_map.y):
                    inside.add(index)
                if gate.is_closed:
                    self.waited[index] = self.waited.get(index, 0) + 1
            self.most = max(self.most, len(inside))
            self.entered |= inside

        return look

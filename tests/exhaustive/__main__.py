"""Command: plays placements of robots on a small map and says how many were checked.

python -m tests.exhaustive ring 3 --jobs 2                 # all placements of three robots
python -m tests.exhaustive aisle 4 --every 100             # a part of them
python -m tests.exhaustive corner 5 --sample 200 --seed 1  # some at random

A run that does not end, or in which robots touch, is played again and drawn: a picture for each
simulated second in which somebody has moved.
"""

import argparse
import functools
import multiprocessing
import sys
import time
from collections.abc import Iterable, Iterator, Sequence

from swarm_common.model.records import CONTROL_PERIOD, Pose
from tests.fakes.cells import MAPS, CellMap, Ending, Placement, play


def main() -> int:
    """Play the placements that the command line asks for; return 1 if one fails."""
    maps = {cells.name: cells for cells in MAPS}
    parser = argparse.ArgumentParser(prog="python -m tests.exhaustive")
    parser.add_argument("map", choices=sorted(maps))
    parser.add_argument("robots", type=int, choices=range(1, 9))
    parser.add_argument("--every", type=int, default=1, help="play every n-th placement only")
    parser.add_argument("--sample", type=int, metavar="N", help="play N placements at random")
    parser.add_argument("--seed", type=int, default=0, help="of the sample")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    asked = parser.parse_args()
    cells = maps[asked.map]
    if asked.robots > len(cells.free):
        parser.error(f"{cells.name} has {len(cells.free)} cells; {asked.robots} robots asked for")
    if min(asked.every, asked.jobs, 1 if asked.sample is None else asked.sample) < 1:
        parser.error("--every, --jobs and --sample must be at least 1")
    if asked.sample is None:
        placements = list(cells.placements(asked.robots))
        chosen = placements[:: asked.every]
        part = f"{len(chosen)} of {len(placements)} placements"
        part += f" (one per symmetry of {len(cells.symmetries)})"
    else:
        chosen = list(cells.sample(asked.robots, asked.sample, asked.seed))
        part = f"{len(chosen)} placements at random (seed {asked.seed})"
    started = time.monotonic()
    failed, untold = 0, 0
    with multiprocessing.Pool(asked.jobs) as pool:
        ends = pool.imap(functools.partial(play, cells), chosen, chunksize=4)
        for placement, end in zip(chosen, note(ends, len(chosen)), strict=True):
            if end.is_done and not end.contacts:
                continue
            said = cells.conditions(placement)
            failed, untold = failed + 1, untold + (said.is_guaranteed or end.contacts > 0)
            sys.stdout.write(f"FAILED {placement}: {end}; {said}\n{film(cells, placement)}\n")
    sys.stdout.write(
        f"{cells.name}, {asked.robots} robots: {part}, {failed} failed, {untold} of them with a"
        f" contact or though all conditions hold, {time.monotonic() - started:.0f} s\n"
    )
    return 1 if untold else 0


def note(ends: Iterable[Ending], count: int) -> Iterator[Ending]:
    """Pass the endings on and tell the worst figures at the end."""
    longest, gap = 0, 9.0
    for number, end in enumerate(ends, 1):
        longest, gap = max(longest, end.ticks), min(gap, end.gap)
        yield end
        if number % 200 == 0 or number == count:
            sys.stdout.write(f"  {number}/{count}: at most {longest} ticks, tubes {gap:.3f} m\n")
            sys.stdout.flush()


def film(cells: CellMap, placement: Placement) -> str:
    """Play a placement and return its pictures, those that are equal to the last one left out."""
    period = round(1.0 / CONTROL_PERIOD)
    pictures: dict[int, str] = {}

    def watch(tick: int, poses: Sequence[Pose]) -> None:
        picture = cells.picture(placement, poses)
        if tick % period == 0 and picture != next(reversed(pictures.values()), ""):
            pictures[tick] = picture

    play(cells, placement, watch=watch)
    return "\n".join(
        f"{tick * CONTROL_PERIOD:.0f} s\n{picture}" for tick, picture in pictures.items()
    )


if __name__ == "__main__":
    sys.exit(main())

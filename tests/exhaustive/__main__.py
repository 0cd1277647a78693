"""Command: plays all placements of robots on a small map and says how many were checked.

python -m tests.exhaustive ring 3 --jobs 2
python -m tests.exhaustive aisle 4 --every 100
"""

from __future__ import annotations

import argparse
import functools
import multiprocessing
import sys
import time
from collections.abc import Iterable, Iterator

from tests.fakes.cells import MAPS, Ending, Placement, play


def main() -> int:
    """Play the placements that the command line asks for; return 1 if one fails."""
    maps = {cells.name: cells for cells in MAPS}
    parser = argparse.ArgumentParser(prog="python -m tests.exhaustive")
    parser.add_argument("map", choices=sorted(maps))
    parser.add_argument("robots", type=int, choices=range(1, 9))
    parser.add_argument("--every", type=int, default=1, help="play every n-th placement only")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    asked = parser.parse_args()
    cells = maps[asked.map]
    placements = list(cells.placements(asked.robots))
    chosen = placements[:: asked.every]
    started = time.monotonic()
    with multiprocessing.Pool(asked.jobs) as pool:
        ends = pool.imap(functools.partial(play, cells), chosen, chunksize=4)
        failed = sum(report(*pair) for pair in zip(chosen, note(ends, len(chosen)), strict=True))
    sys.stdout.write(
        f"{cells.name}, {asked.robots} robots: {len(chosen)} of {len(placements)} placements"
        f" (one per symmetry of {len(cells.symmetries)}), {failed} failed,"
        f" {time.monotonic() - started:.0f} s\n"
    )
    return 1 if failed else 0


def note(ends: Iterable[Ending], count: int) -> Iterator[Ending]:
    """Pass the endings on and tell the worst figures at the end."""
    longest, gap = 0, 9.0
    for number, end in enumerate(ends, 1):
        longest, gap = max(longest, end.ticks), min(gap, end.gap)
        yield end
        if number % 200 == 0 or number == count:
            sys.stdout.write(f"  {number}/{count}: at most {longest} ticks, tubes {gap:.3f} m\n")
            sys.stdout.flush()


def report(placement: Placement, end: Ending) -> bool:
    """Print a failure; return whether it is one."""
    is_failure = not end.is_done or end.contacts > 0
    if is_failure:
        sys.stdout.write(f"FAILED {placement}: {end}\n")
    return is_failure


if __name__ == "__main__":
    sys.exit(main())

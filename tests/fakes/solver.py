#!/usr/bin/env python3
"""External solver that plans right or wrong, as SOLVER_MODE says; called as `--central-solver` is.

right       one robot after the other, around those that stand
collide     each by its shortest way, whoever is there
stand       nobody moves
swap        two robots change places, then all go on as in `right`
jump        all are at their goals after one step
start       begins one cell beside the first robot
wall        the first robot enters a cell that is not free
twice       the first robot has no place in the second step
gap         a step is missing
nan         a place is not a number
text        a line is no step
empty       an empty file
unsolved    says that there is no plan
none        no file
fail        exit code 3 with a complaint
crash       ends by a signal
late        right for the first plan of a run, a failure afterwards; SOLVER_COUNT is a file
hang        never ends, nor does its child, whose number is written to SOLVER_COUNT
"""

import os
import random
import signal
import subprocess
import sys
import time
from collections import deque
from pathlib import Path

Cell = tuple[int, int]
MOST_TURNS = 500


def read(given: dict[str, str]) -> tuple[set[Cell], list[Cell], list[Cell]]:
    """Return the free cells, and start and goal of each robot."""
    rows = Path(given["-m"]).read_text().splitlines()[4:]
    free = {(x, y) for y, row in enumerate(rows) for x, sign in enumerate(row) if sign == "."}
    lines = Path(given["-i"]).read_text().splitlines()[1:]
    robots = [[int(word) for word in line.split("\t")[4:8]] for line in lines]
    assert len(robots) == int(given["-N"])
    return free, [(r[0], r[1]) for r in robots], [(r[2], r[3]) for r in robots]


def way(free: set[Cell], start: Cell, goal: Cell) -> list[Cell]:
    """Return a shortest way without its start; empty without one."""
    before, queue = {start: start}, deque([start])
    while queue and goal not in before:
        x, y = queue.popleft()
        for cell in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if cell in free and cell not in before:
                before[cell] = (x, y)
                queue.append(cell)
    found = [goal] if goal in before else []
    while found and found[-1] != start:
        found.append(before[found[-1]])
    return found[-2::-1]


def in_turns(free: set[Cell], start: list[Cell], goals: list[Cell]) -> list[list[Cell]]:
    """Return a plan in which one robot drives at a time.

    Where none can reach its goal, the next one in turn goes anywhere, to make way.
    """
    now, plan, chance = list(start), [list(start)], random.Random(0)
    for turn in range(MOST_TURNS):
        plan_before = len(plan)
        for robot, goal in enumerate(goals):
            drive(plan, now, robot, way(free - set(now), now[robot], goal))
        if now == goals:
            break
        if len(plan) == plan_before:
            robot = turn % len(now)
            aim = chance.choice(sorted(free))
            drive(plan, now, robot, way(free - set(now), now[robot], aim))
    return plan


def drive(plan: list[list[Cell]], now: list[Cell], robot: int, cells: list[Cell]) -> None:
    for cell in cells:
        now[robot] = cell
        plan.append(list(now))


def at_once(free: set[Cell], start: list[Cell], goals: list[Cell]) -> list[list[Cell]]:
    ways = [[a, *way(free, a, b)] for a, b in zip(start, goals, strict=True)]
    longest = max(map(len, ways))
    return [[cells[min(t, len(cells) - 1)] for cells in ways] for t in range(longest)]


def exchange(free: set[Cell], start: list[Cell]) -> list[list[Cell]]:
    cells = way(free - set(start[2:]), *start[:2]) if len(start) > 1 else []
    if not cells:
        return []
    plan = [start, *([cell, *start[1:]] for cell in cells[:-1])]
    return [*plan, [start[1], plan[-1][0], *start[2:]]]


def wrong(mode: str, free: set[Cell], plan: list[list[Cell]]) -> list[list[Cell]]:
    """Return a plan with the fault of a mode."""
    first = plan[0][0]
    match mode:
        case "stand":
            return plan[:1]
        case "swap":
            return exchange(free, plan[0]) or plan
        case "jump":
            return [plan[0], plan[-1]]
        case "start":
            return [[(first[0] + 1, first[1]), *plan[0][1:]], *plan]
        case "wall":
            outside = next((x, y) for x in range(99) for y in range(99) if (x, y) not in free)
            return [plan[0], [outside, *plan[0][1:]], *plan]
        case "twice":
            return [plan[0], plan[0][1:], *plan]
        case _:
            return plan


def text(mode: str, plan: list[list[Cell]]) -> str:
    """Return the result file."""
    lines = [f"{t}:" + "".join(f"({x},{y})," for x, y in cells) for t, cells in enumerate(plan)]
    match mode:
        case "gap":
            lines = [lines[0], *(line for line in lines[2:])]
        case "nan":
            lines.append(f"{len(lines)}:" + "(1,nan)," * len(plan[0]))
        case "text":
            lines.append("and so on")
        case "empty":
            return ""
        case "unsolved":
            return "agents=1\nsolved=0\nsolution=\n"
    return "\n".join(["agents=1", "solved=1", "solution=", *lines]) + "\n"


def main() -> None:
    """Plan once."""
    mode = os.environ.get("SOLVER_MODE", "right")
    given = dict(zip(sys.argv[1::2], sys.argv[2::2], strict=True))
    count = Path(os.environ.get("SOLVER_COUNT", os.devnull))
    if mode == "late":
        plans = count.read_text() if count.exists() else ""
        count.write_text(plans + ".")
        mode = "fail" if plans else "right"
    if mode == "fail":
        sys.exit("first line\nno way\u00a0found")
    if mode == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if mode == "hang":
        child = subprocess.Popen(["sleep", "1000"])
        count.write_text(str(child.pid))
        sys.stderr.write("still searching\n")
        sys.stderr.flush()
        time.sleep(1000)
    if mode == "none":
        return
    free, start, goals = read(given)
    plan = (at_once if mode == "collide" else in_turns)(free, start, goals)
    Path(given["-o"]).write_text(text(mode, wrong(mode, free, plan)))


if __name__ == "__main__":
    main()

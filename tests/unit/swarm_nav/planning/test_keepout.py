"""Keepout zones are walls to plan with, which the LiDAR does not see."""

import dataclasses

import numpy as np
import pytest

from swarm_bench.baselines.planning import plain_planner
from swarm_common.model.grid import KEEPOUT, OCCUPIED
from swarm_common.model.records import Pose, Scan
from swarm_common.model.sites import Sites
from swarm_common.model.zones import KeepoutZone, Zones
from swarm_nav.behaviour import costmap as costmaps
from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import ErrorCode, GoalKind, Outcome, PlanError
from swarm_nav.planning.planner import Planner
from swarm_nav.planning.terrain import terrain_for
from swarm_nav.traffic.conditions import conditions
from tests.fakes.navigation import Squad, config, robot_in, room, waffle

HALL = room(8.0, 6.0)
BOX = (3.0, 0.0, 4.0, 4.5)  # leaves a way along the north wall


def zones(*boxes):
    corners = [((a, b), (c, b), (c, d), (a, d)) for a, b, c, d in boxes]
    return Zones(keepout=tuple(KeepoutZone(str(k), each) for k, each in enumerate(corners)))


MARKED = zones(BOX).mark(HALL)


def terrain(grid):
    c = NavConfig()
    return terrain_for(grid, c.planner, c.costmap, waffle().circumscribed_radius)


def planner(grid=MARKED):
    return Planner(terrain(grid), NavConfig().planner)


def squad(pose, grid=HALL, box=BOX):
    return Squad(grid, [pose], config(), Sites(zones=zones(box)))


def test_a_zone_is_a_wall_for_plans_paths_and_conditions():
    walled = terrain(room(8.0, 6.0, BOX))
    marked = terrain(MARKED)
    for name in ("clearance", "base", "lane", "heading", "parking"):
        ours, theirs = getattr(marked.lattice, name), getattr(walled.lattice, name)
        assert np.array_equal(ours, theirs), name
    assert np.array_equal(marked.walls.distance, terrain(HALL).distance)
    assert terrain(HALL).walls is terrain(HALL).field
    robots = [(waffle(), NavConfig())] * 3
    starts, goals = [(1.0, 1.0)] * 3, [[(6.0, 1.0)], [(3.5, 1.0)], [(1.0, 1.0)]]
    for box in (BOX, (3.0, 0.0, 4.0, 6.0), (3.0, 0.0, 4.0, 5.1)):
        found = conditions(robots, zones(box).mark(HALL), starts, goals)
        assert found == conditions(robots, room(8.0, 6.0, box), starts, goals)
        assert found.findings
    path = planner().plan((2.0, 1.0), (6.0, 1.0), planner().no_extra())
    assert min(planner().terrain.clearance(x, y) for x, y in path.tolist()) > 0.238
    assert path[:, 1].max() > 4.5
    there = plain_planner(MARKED, NavConfig(), waffle().circumscribed_radius)
    path = there.plan((2.0, 1.0), (6.0, 1.0), there.no_extra())
    assert path[:, 1].max() > BOX[3]


def test_the_lidar_does_not_take_a_zone_for_a_wall_but_the_costmap_shows_it():
    s = robot_in(MARKED, Pose(2.0, 2.0, 0.0))
    ranges = np.full(360, np.inf, np.float32)
    ranges[0] = 1.5  # something in the zone
    scan = Scan(s.tick, 0.0, 2.0 * np.pi / 360, 0.12, 3.5, ranges)
    s.obstacles.update(scan, s.pose, s.terrain, s.neighbors)
    assert len(s.obstacle_points()) == 1
    s = robot_in(MARKED, Pose(2.0, 2.0, 0.0))
    costs = costmaps.compose(s, waffle().inscribed_radius, None)
    assert MARKED.keepout is not None
    assert (costs.cells[MARKED.keepout == KEEPOUT] == costmaps.LETHAL).all()
    assert costs.cells[MARKED.cell_of(2.95, 2.0)] == costmaps.INSCRIBED
    local = costmaps.compose(s, waffle().inscribed_radius, 3.0)
    lethal = local.cells == costmaps.LETHAL
    assert lethal.any(axis=0).sum() == 10  # 0.5 m of the zone


def test_a_goal_or_a_given_path_into_a_zone_is_refused():
    with pytest.raises(PlanError, match=r"\(3.95, 1.00\) lies in a keepout zone") as error:
        planner().plan((2.0, 1.0), (3.95, 1.0), planner().no_extra())  # 0.05 m from free floor
    assert error.value.code is ErrorCode.GOAL_OCCUPIED
    one = squad(Pose(2.0, 1.0, 0.0))
    one.send(0, Pose(3.5, 1.0, 0.0))
    one.run_until(lambda: bool(one.ended(0)), 200)
    assert one.ended(0)[0].error_code is ErrorCode.GOAL_OCCUPIED
    one = squad(Pose(2.0, 1.0, 0.0))
    points = np.column_stack((np.linspace(2.0, 6.0, 80), np.full(80, 1.0)))
    one.send(0, Pose(6.0, 1.0, 0.0), kind=GoalKind.FOLLOW_PATH, path_map=points)
    one.run_until(lambda: bool(one.ended(0)), 200)
    assert one.ended(0)[0].error_code is ErrorCode.NO_VALID_CONTROL
    assert "leads into a keepout zone" in one.ended(0)[0].message


@pytest.mark.parametrize("start", [Pose(3.5, 2.0, 0.0), Pose(3.05, 4.0, 3.0), Pose(3.5, 0.5, 1.5)])
def test_a_robot_in_a_zone_leaves_it_and_does_not_come_back(start):
    one = squad(start)
    one.send(0, Pose(6.0, 1.0, 0.0))
    inside = []
    for _ in range(900):
        one.run(1)
        inside.append(BOX[0] < one.bodies[0].pose.x < BOX[2] and one.bodies[0].pose.y < BOX[3])
        if one.ended(0):
            break
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    assert inside.index(False) == len(inside) - inside[::-1].index(True)


def test_a_robot_in_a_zone_backs_out_but_not_through_a_wall():
    one = squad(Pose(3.9, 1.0, 3.14159))
    one.send(0, kind=GoalKind.BACKUP, distance=0.6, speed=0.2)
    one.run_until(lambda: bool(one.ended(0)), 200)
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    two = squad(Pose(4.6, 1.0, 0.0))
    two.send(0, kind=GoalKind.BACKUP, distance=0.6, speed=0.2)
    two.run_until(lambda: bool(two.ended(0)), 200)
    assert two.ended(0)[0].error_code is ErrorCode.BACKUP_COLLISION_AHEAD
    assert "keepout zone" in two.ended(0)[0].message
    grid = room(8.0, 6.0, (4.0, 0.0, 4.15, 6.0))
    path = planner(zones(BOX).mark(grid)).plan((3.8, 2.0), (1.0, 1.0), planner().no_extra())
    assert path[:, 0].max() < 4.0


def test_greys_of_a_mask_are_driven_round_where_it_is_short():
    layer = np.zeros(HALL.cells.shape, np.int8)
    layer[40:80, 60:80] = 99  # from (3, 2) to (4, 4)
    grid = dataclasses.replace(HALL, keepout=layer)
    there = planner(grid)
    path = there.plan((1.0, 2.2), (7.0, 2.2), there.no_extra())
    cells = [grid.cell_of(x, y) for x, y in path.tolist()]
    assert not any(layer[cell] for cell in cells)
    layer[:] = 99 * (HALL.cells != OCCUPIED)  # where all costs more, it is driven all the same
    there = planner(dataclasses.replace(HALL, keepout=layer.copy()))
    assert len(there.plan((1.0, 2.2), (7.0, 2.2), there.no_extra())) > 100


def test_nobody_makes_way_into_a_zone():
    """Refuges, parking places and retreats are all looked for by `nearest`."""
    there = planner()
    extra, lattice = there.no_extra(), there.lattice
    rows, columns = np.indices(lattice.base.shape)
    x, y = (columns + 0.5) * lattice.step, (rows + 0.5) * lattice.step
    inside = (x > BOX[0]) & (x < BOX[2]) & (y < BOX[3])
    assert there.nearest((2.5, 2.0), extra, inside.astype(np.uint8), 20.0) is None
    beyond = there.nearest((2.5, 2.0), extra, (x > BOX[2]).astype(np.uint8), 20.0)
    assert beyond[:, 1].max() > BOX[3]
    out = there.nearest((3.5, 2.0), extra, (x > BOX[2]).astype(np.uint8), 20.0)
    assert out[-1, 0] > BOX[2]


def test_a_mask_that_comes_on_the_way_changes_it():
    mask = dataclasses.replace(HALL, cells=zones(BOX).mark(HALL).keepout)
    one = Squad(HALL, [Pose(1.5, 1.5, 0.0)], config())
    one.send(0, Pose(6.5, 1.5, 0.0))
    one.run(20)
    one.robots[0].services.on_keepout_mask(mask)
    for _ in range(800):
        one.run(1)
        x, y = one.bodies[0].pose.x, one.bodies[0].pose.y
        assert not (BOX[0] <= x <= BOX[2] and y <= BOX[3])
        if one.ended(0):
            break
    assert one.ended(0)[0].outcome is Outcome.SUCCEEDED
    one.robots[0].services.on_keepout_mask(
        dataclasses.replace(mask, cells=np.zeros_like(mask.cells))
    )
    assert not one.robots[0]._s.terrain.grid.keepout.any()

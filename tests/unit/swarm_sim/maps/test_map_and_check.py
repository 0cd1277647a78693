"""Maps drawn from worlds, and the checks at the start."""

from dataclasses import replace

import numpy as np
import pytest

from swarm_common.files.map_io import load_map, map_path
from swarm_common.model.errors import ConfigError, MapError
from swarm_common.model.grid import FREE, OCCUPIED, UNKNOWN
from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_describe.robots.loading import load_robot, open_robot
from swarm_describe.worlds.reader import load_world
from swarm_describe.worlds.world_file import world_names
from swarm_sim.maps.check import check_map, check_sites
from swarm_sim.maps.draw_map import draw_world
from swarm_sim.maps.raster import draw_on
from swarm_sim.ros import build
from swarm_sim.ros.settings import RobotEntry, Settings
from swarm_sim.scene.section import Section
from tests.fakes.scenes import section_at
from tests.unit.swarm_sim.sensing.test_lidar import make_section


def value_at(grid, x, y):
    row, column = grid.cell_of(x, y)
    return int(grid.cells[row, column])


@pytest.mark.parametrize("name", world_names())
def test_the_shipped_map_is_the_one_drawn_from_the_world(name):
    shipped, drawn = load_map(map_path(name)), draw_world(load_world(name))
    assert np.array_equal(shipped.cells, drawn.cells)
    assert (shipped.origin_x, shipped.origin_y) == (drawn.origin_x, drawn.origin_y)
    check_map(load_world(name), shipped)
    check_sites(load_world(name), load_robot("turtlebot3_waffle"))


def test_walls_are_drawn_to_the_cell_and_an_empty_world_is_an_empty_map():
    grid = load_map(map_path("slim_blockage"))
    assert value_at(grid, -8.325, 0.0) == OCCUPIED  # west wall, inner face at -8.32
    assert value_at(grid, -8.315, 0.0) == FREE
    assert value_at(grid, 0.0, -4.825) == OCCUPIED  # south wall, inner face at -4.82
    assert value_at(grid, 0.0, -4.815) == FREE
    assert value_at(grid, -4.5, 2.0) == UNKNOWN  # the island is hollow
    assert value_at(grid, 6.0, -3.0) == UNKNOWN  # so is the box in the south east
    assert value_at(grid, -8.9, 0.0) == UNKNOWN
    nothing = Section((), np.zeros((0, 3)), ())
    assert not draw_on((4, 4), 0.1, 0.0, 0.0, nothing).cells.any()
    assert section_at(replace(load_world("hall_12"), bodies=()), 0.1).bounds() == (0, 0, 0, 0)


def test_a_cell_is_occupied_if_and_only_if_an_obstacle_reaches_into_it():
    rng = np.random.default_rng(3)
    section = make_section(rng, 5, 2)
    grid = draw_on((200, 200), 0.05, -5.0, -5.0, section)
    samples = np.linspace(-0.0199, 0.0199, 9)  # of a cell, shrunk by the allowed spill
    for row, column in rng.integers(0, 200, (4000, 2)):
        x, y = grid.center_of(int(row), int(column))
        dx, dy = np.meshgrid(samples, samples)
        points = np.column_stack([x + dx.ravel(), y + dy.ravel()])
        if any(inside(points, outline).any() for outline in section.outlines()):
            assert grid.cells[row, column] == OCCUPIED
        elif grid.cells[row, column] == OCCUPIED:  # then a corner is hardly inside
            wide = np.column_stack([x + dx.ravel() * 1.26, y + dy.ravel() * 1.26])
            assert any(inside(wide, outline).any() for outline in section.outlines())


def inside(points, outline):
    edges = np.roll(outline, -1, axis=0) - outline
    sides = [
        edge[0] * (points[:, 1] - corner[1]) - edge[1] * (points[:, 0] - corner[0]) >= 0.0
        for corner, edge in zip(outline, edges, strict=True)
    ]
    return np.all(sides, axis=0)


def test_map_offset_of_one_metre_is_detected():
    """The original's map lay about 1 m off in y, so that loader_1 was inside an obstacle."""
    scene, grid = load_world("slim_blockage"), load_map(map_path("slim_blockage"))
    with pytest.raises(MapError, match="would fit if it were moved by") as caught:
        check_map(scene, replace(grid, origin_y=grid.origin_y + 1.0))
    message = str(caught.value)
    assert "moved by (+0.00, -1.00) m" in message
    assert "the world has an obstacle that the map lacks around (" in message
    assert "swarm-map draw slim_blockage" in message


@pytest.mark.parametrize("shift", [(0.2, 0.0), (0.0, -0.3), (-1.0, 0.0)])
def test_smaller_offsets_are_detected_too(shift):
    scene, grid = load_world("slim_blockage"), load_map(map_path("slim_blockage"))
    moved = replace(grid, origin_x=grid.origin_x + shift[0], origin_y=grid.origin_y + shift[1])
    with pytest.raises(MapError):
        check_map(scene, moved)


def test_maps_within_the_tolerance_pass_and_others_do_not():
    scene, grid = load_world("slim_blockage"), load_map(map_path("slim_blockage"))
    check_map(scene, replace(grid, origin_x=grid.origin_x + 0.06))
    scene = load_world("slim_blockage")
    check_map(scene, draw_world(scene, resolution=0.1))
    part = replace(scene, bodies=tuple(b for b in scene.bodies if "island_east" not in b.name))
    with pytest.raises(MapError, match="the world has an obstacle that the map lacks"):
        check_map(scene, draw_world(part))
    with pytest.raises(MapError, match="the map has an obstacle that the world lacks"):
        check_map(part, draw_world(scene))
    scene, grid = load_world("slim_blockage"), load_map(map_path("slim_blockage"))
    with pytest.raises(MapError, match="the map only from"):
        check_map(scene, replace(grid, cells=grid.cells[:150]))


@pytest.mark.parametrize(
    ("x", "message"), [(-8.4, "inside an obstacle"), (-8.2, "m from an obstacle")]
)
def test_a_station_inside_a_wall_is_refused(x, message):
    scene = load_world("slim_blockage")
    bad = replace(scene, sites=Sites(stations={"loader_1": Pose(x, 0.0, 0.0)}))
    with pytest.raises(ConfigError, match="station 'loader_1'") as caught:
        check_sites(bad, load_robot("turtlebot3_waffle"))
    assert message in str(caught.value)


def test_a_circuit_through_a_wall_is_refused():
    scene = load_world("slim_blockage")
    ring = ((0.0, 0.0), (1.0, 0.0), (-4.0, 0.0))
    with pytest.raises(ConfigError, match="corner 3 of circuit 'ring'"):
        check_sites(
            replace(scene, sites=Sites(circuits={"ring": ring})), load_robot("turtlebot3_waffle")
        )


@pytest.mark.parametrize(
    ("broken", "with_lidar", "end"),
    [
        (
            False,
            True,
            "turtlebot3_waffle: it may hit one that falls silent and that it never heard",
        ),
        (True, True, "does not meet a turtlebot3_waffle: it may hit one that is broken"),
        (True, False, "without LiDARs no robot sees the broken ones: it may hit them"),
    ],
)
def test_a_world_says_whose_lidar_does_not_meet_which_robots(broken, with_lidar, end):
    spot = Pose(3.0, 3.0, 0.0) if broken else None
    robots = (
        RobotEntry("Srobot1", "turtlebot3_burger"),
        RobotEntry("Srobot2", "turtlebot3_waffle", spot),
    )
    for entries, count in ((robots, 1), (robots[:1], 0)):
        setup, world = build.build(
            Settings(world="slim_blockage", robots=entries, engine="planar", with_lidar=with_lidar)
        )
        world.close()
        said = [note for note in setup.scene.notes if note.endswith(end)]
        assert len(said) == count
        assert list(setup.unseen(0.26, build.BROKEN)) == (said if broken else [])


def test_a_world_says_nothing_of_a_lone_robot_and_checks_at_its_scan_height(monkeypatch):
    for count, margin, expected in ((1, 0.26, 0), (2, 0.26, 1), (2, 0.65, 0)):
        robots = tuple(RobotEntry(f"Srobot{k}", "carrier") for k in range(1, count + 1))
        setup, world = build.build(
            Settings(world="crossing", robots=robots, engine="planar", body_margin=margin)
        )
        world.close()
        assert len([note for note in setup.scene.notes if "0.64 or more" in note]) == expected
    robot = open_robot("turtlebot3_waffle")
    tall = replace(robot.spec, lidar=replace(robot.spec.lidar, z=0.2))
    heights: list[float] = []
    monkeypatch.setattr(build, "open_robot", lambda _: replace(robot, spec=tall))
    monkeypatch.setattr(
        build, "check_map", lambda scene, grid, height, reach: heights.append(height)
    )
    settings = Settings(
        world="crossing", robots=(RobotEntry("Srobot1", "turtlebot3_waffle"),), engine="planar"
    )
    build.build(settings)[1].close()
    assert heights == [0.2]


def test_a_station_without_room_is_refused_with_a_cure_or_noted_if_nobody_goes_there():
    scene = load_world("hall_12")
    tight = Sites(stations={"a": Pose(0.0, 0.0, 0.0), "b": Pose(5.9, 0.0, 0.0)})
    scene = replace(scene, sites=tight)
    spec = load_robot("turtlebot3_waffle")
    with pytest.raises(ConfigError, match=r"'b'.*: move it 0\.\d\d m away from it, or take"):
        check_sites(scene, spec)
    (note,) = check_sites(scene, spec, {"a"})
    assert note.endswith("no mission of this run sends a robot there")

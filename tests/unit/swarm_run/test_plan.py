"""What a fleet makes of a run: model, limits and mission of each robot."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from msgspec import structs

from swarm_commander.mission.runner import itineraries
from swarm_common.files.params_io import flatten
from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError
from swarm_common.model.records import Pose
from swarm_describe.worlds.world_file import find_world
from swarm_mission.routes import goals
from swarm_run.host_options import Role
from swarm_run.plan import check_plan
from swarm_run.spec import RunSpec

FLEET = """order: mixed
groups:
  - {model: turtlebot3_burger, count: 2, limits: {max_vel_x: 0.2}}
  - {model: turtlebot3_waffle, count: 1, mission: short.yaml}
"""
ROUTE = "route:\n  - stations: [loader_1, shipping]\n"


def make_plan(folder, params=None):
    (folder / "short.yaml").write_text(ROUTE)
    path = folder / "fleet.yaml"
    path.write_text(FLEET.replace("short.yaml", str(folder / "short.yaml")))
    if params is not None:
        (folder / "params.yaml").write_text(params)
    return check_plan(
        RunSpec(
            fleet=str(path),
            mission="loading_route",
            params=str(folder / "params.yaml") if params is not None else None,
        )
    )


def test_robots_get_their_limits_and_the_users_parameters_win(tmp_path):
    plan = make_plan(tmp_path)
    models = [robot["model"] for robot in plan.world_config(tmp_path / "v.json")["robots"]]
    assert models == ["turtlebot3_burger", "turtlebot3_waffle", "turtlebot3_burger"]
    assert plan.spec.model == "2 turtlebot3_burger, 1 turtlebot3_waffle"
    for number, speed, turn, track in ((1, 0.2, 2.84, 0.160), (2, 0.26, 1.82, 0.287)):
        flat = flatten(plan.parameter_file(number, Pose(0.0, 0.0, 0.0)))
        values = {name.split("ros__parameters.")[1]: value for name, value in flat.items()}
        assert (values["max_vel_x"], values["max_vel_theta"]) == (speed, turn)
        assert values["robot.wheel_separation"] == track
    text = "/Srobot1/navigator:\n  ros__parameters:\n    max_vel_x: 0.1\n"
    flat = flatten(make_plan(tmp_path, text).parameter_file(1, Pose(0.0, 0.0, 0.0)))
    assert flat["/Srobot1/navigator.ros__parameters.max_vel_x"] == 0.1


def test_the_world_knows_what_every_robot_allows_for_of_unseen_bodies(tmp_path):
    text = "/Srobot{}/navigator: {{ros__parameters: {{costmap: {{unknown_body_margin: {}}}}}}}\n"
    for params, margin in (
        (None, 0.26),
        (text.format(1, 0.1), 0.11),
        (text.format("*", 0.6), 0.61),
    ):
        config = make_plan(tmp_path, params).world_config(tmp_path / "v.json")
        assert config["body_margin"] == pytest.approx(margin)


def test_a_group_has_a_mission_and_the_drive_is_the_worlds(tmp_path):
    plan = make_plan(tmp_path)
    config = plan.runner_config([Pose(float(i), 0.0, 0.0) for i in range(3)])
    totals = [itinerary.total for itinerary in itineraries(config) if itinerary is not None]
    assert totals == [8, 2, 8]
    for drive, engine in ((None, "bullet"), ("wheels", "bullet"), ("planar", "planar")):
        plan = check_plan(RunSpec(swarm_size=2, drive=drive))
        assert plan.world_config(tmp_path / "v.json").get("engine", "bullet") == engine
    with pytest.raises(ConfigError, match="planar"):
        check_plan(RunSpec(drive="wings"))


def test_where_missions_lead_is_known_before_they_begin(tmp_path):
    plan = make_plan(tmp_path)
    homes = [Pose(float(i), 0.0, 0.0) for i in range(3)]
    found = goals(plan.runner_config(homes))
    stations = {(pose.x, pose.y) for pose in plan.sites.stations.values()}
    assert [len(places) for places in found.values()] == [8, 2, 8]
    assert set(found["Srobot1"]) - {(0.0, 0.0)} <= stations
    assert set(found["Srobot3"]) - {(2.0, 0.0)} <= stations
    roaming = check_plan(RunSpec(swarm_size=3, world="pillars", mission="roam"))
    places = {(pose.x, pose.y) for pose in roaming.sites.places}
    assert all(set(route) <= places for route in goals(roaming.runner_config(homes)).values())
    endless = check_plan(RunSpec(swarm_size=2, mission="loading_route", laps=10**9))
    assert set(goals(endless.runner_config(homes[:2]))) == {"Srobot1", "Srobot2"}  # and soon
    idle = check_plan(RunSpec(swarm_size=2))
    assert goals(idle.runner_config(homes[:2])) == {}


def test_too_few_places_are_refused_before_the_start(tmp_path):
    folder = tmp_path / "hall"
    folder.mkdir()
    for file in find_world("pillars").parent.iterdir():
        shutil.copy(file, folder)
    sites = load_sites(folder / "sites.yaml")
    rows = "".join(f"  - [{p.x}, {p.y}, {p.yaw}]\n" for p in sites.places[:4])
    (folder / "sites.yaml").write_text(f"places:\n{rows}")
    world, path = str(folder / "world.sdf"), tmp_path / "own.yaml"
    path.write_text("route: [{own_place: true}]\n")
    for mission in ("roam", str(path)):
        check_plan(RunSpec(swarm_size=4, world=str(world), mission=str(mission)))
        with pytest.raises(ConfigError, match=r"each of 5 robots; .*hall/sites.yaml.* has 4"):
            check_plan(RunSpec(swarm_size=5, world=str(world), mission=str(mission)))


def test_what_is_restarted_reads_copies(tmp_path):
    """A navigator or mission process that was restarted read the user's files as they were then."""
    own = tmp_path / "own"
    shutil.copytree(find_world("slim_blockage").parent, own)
    route = tmp_path / "tour.yaml"
    route.write_text("route: [{stations: [loader_1]}]", encoding="utf-8")
    options = RunSpec(swarm_size=2, world=str(own / "world.sdf"), mission=str(route))
    plan = check_plan(options).with_copies(tmp_path / "copies")
    homes = [Pose(0.0, 0.0, 0.0)] * 2
    before = itineraries(plan.runner_config(homes))[0]
    for path in (route, own / "sites.yaml"):
        path.write_text("not: [what", encoding="utf-8")
    config = plan.runner_config(homes)
    after = itineraries(config)[0]
    assert before is not None
    assert after is not None
    assert vars(before) == vars(after)
    parameters = plan.parameter_file(1, homes[0])["/Srobot1/navigator"]["ros__parameters"]
    assert parameters["sites"] == config["sites"]
    read = load_sites(Path(config["sites"]))
    assert repr(read.zones) == repr(plan.sites.zones)
    assert replace(read, zones=plan.sites.zones) == plan.sites
    assert Path(config["robots"][0]["mission"]).name == route.name


def test_filter_masks_reach_every_process_as_copies(tmp_path):
    """A world of its own with a mask in its sites, and another mask of the command line."""
    own = tmp_path / "own"
    shutil.copytree(find_world("slim_blockage").parent, own)
    for name, grey in (("keep", 254), ("slow", 100)):
        (tmp_path / f"{name}.pgm").write_bytes(b"P5 2 2 255\n" + bytes([grey] * 4))
        (tmp_path / f"{name}.yaml").write_text(
            f"{{image: {name}.pgm, resolution: 1, origin: [0, 0, 0], mode: raw, type: 2}}"
        )
    sites = own / "sites.yaml"
    text = sites.read_text("utf-8")
    assert "zones: {" in text
    sites.write_text(text.replace("zones: {", "zones: {speed_mask: ../slow.yaml, "), "utf-8")
    (tmp_path / "keep.yaml").write_text((tmp_path / "keep.yaml").read_text().replace("2}", "0}"))
    options = RunSpec(
        swarm_size=2, world=str(own / "world.sdf"), keepout_mask=str(tmp_path / "keep.yaml")
    )
    plan = check_plan(options).with_copies(tmp_path / "copies")
    (tmp_path / "slow.yaml").unlink()
    (tmp_path / "keep.pgm").unlink()
    homes = [Pose(0.0, 0.0, 0.0)] * 2
    parameters = plan.parameter_file(1, homes[0])["/Srobot1/navigator"]["ros__parameters"]
    paths = {parameters["sites"], plan.world_config(tmp_path / "v.json")["sites"]}
    assert paths == {plan.runner_config(homes)["sites"]}
    found = load_sites(Path(paths.pop()))
    assert found.stations == plan.sites.stations
    assert found.zones.speed_mask is not None
    assert found.zones.limit_at(0.5, 0.5, 0.26) == 100.0
    assert found.zones.keepout_mask is not None


def test_masks_alone_are_sites_too(tmp_path):
    world = tmp_path / "hall.sdf"
    shutil.copy(find_world("slim_blockage"), world)
    (tmp_path / "keep.pgm").write_bytes(b"P5 2 2 255\n" + bytes(4))
    (tmp_path / "keep.yaml").write_text("{image: keep.pgm, resolution: 1, origin: [0, 0, 0]}")
    options = RunSpec(swarm_size=2, world=str(world), keepout_mask=str(tmp_path / "keep.yaml"))
    plan = check_plan(options).with_copies(tmp_path / "copies")
    assert load_sites(plan.sites_file).zones.keepout_at(1.0, 1.0)
    with pytest.raises(ConfigError, match="polygons"):
        check_plan(structs.replace(options, role=Role.WORLD, bind="192.0.2.1"))

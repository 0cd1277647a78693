"""Every interface of simulation_interfaces answers as its feature list says, and at once."""

import math
import re

import pytest
from geometry_msgs.msg import Vector3
from rclpy.action import ActionClient
from simulation_interfaces import action, msg, srv
from simulation_interfaces.msg import Bounds, Result
from simulation_interfaces.msg import SimulatorFeatures as Can

from swarm_common.files.resources import share_directory
from swarm_common.middleware.ros_io import pose_stamped, resource_in
from swarm_common.model.records import Pose
from tests.graph.conftest import ROBOT, WORLD

OK, UNSUPPORTED = Result.RESULT_OK, Result.RESULT_FEATURE_UNSUPPORTED
BOX = """<sdf version="1.7"><model name="crate"><static>true</static><link name="l"><collision
name="c"><geometry><box><size>0.4 0.2 0.6</size></box></geometry></collision></link></model>
</sdf>"""
PLACE = Pose(3.0, 3.0, 0.5 * math.pi)


ROBOTS = 1


def ask(swarm, name, code=OK, /, **fields):
    """Call a service, named like GetEntities, and return its answer."""
    topic = "/sim/" + re.sub("(?<!^)([A-Z])", r"_\1", name).lower()
    kind = getattr(srv, name)
    answer = swarm.call(kind, topic, kind.Request(**fields))
    if code is not None:
        assert answer.result.result == code, answer.result
        assert bool(answer.result.error_message) == (code != OK)
    return answer


def crate(name, pose, **fields):
    entity = msg.SpawnEntity(name=name, initial_pose=pose_stamped(pose, 0), **fields)
    entity.initial_pose.pose.position.z = 0.3
    resource_in(entity).resource_string = BOX
    return entity


def entities(swarm, code=OK, **filters):
    return list(ask(swarm, "GetEntities", code, filters=msg.EntityFilters(**filters)).entities)


def span(bounds):
    high, low = bounds.points
    assert bounds.type == Bounds.TYPE_BOX
    return [high.x - low.x, high.y - low.y, high.z - low.z]


def test_constants_and_servers_are_the_standards(swarm):
    """A client that filters robots by 1 got none when ours was 0."""
    assert (msg.EntityCategory.CATEGORY_ROBOT, msg.EntityCategory.CATEGORY_HUMAN) == (1, 2)
    assert (Result.RESULT_FEATURE_UNSUPPORTED, Result.RESULT_OPERATION_FAILED) == (0, 4)
    assert srv.SpawnEntities.Response.ENTITIES_SPAWN_FAILED == 150
    assert (Bounds.TYPE_BOX, Bounds.TYPE_SPHERE) == (1, 3)
    names = {path.stem for path in (share_directory("interfaces") / "interfaces").glob(
        "simulation_interfaces/srv/*.srv")}  # fmt: skip
    assert len(names) == 22
    wanted = {f"simulation_interfaces/srv/{name}" for name in names}
    swarm.spin_until(
        lambda: (
            wanted <= {t for _, types in swarm.node.get_service_names_and_types() for t in types}
        )
    )


def test_what_is_not_supported_says_why(swarm):
    can = set(ask(swarm, "GetSimulatorFeatures", None).features.features)
    for name, feature in (
        ("LoadWorld", Can.WORLD_LOADING),
        ("UnloadWorld", Can.WORLD_UNLOADING),
        ("SetEntityInfo", Can.ENTITY_INFO_SETTING),
    ):
        assert feature not in can
        ask(swarm, name, UNSUPPORTED)
    tags = msg.TagsFilter(tags=["indoor"])
    assert Can.WORLD_TAGS not in can
    ask(swarm, "GetAvailableWorlds", UNSUPPORTED, filter=tags)
    assert Can.SIMULATION_RESET_TIME not in can
    ask(swarm, "ResetSimulation", UNSUPPORTED, scope=srv.ResetSimulation.Request.SCOPE_TIME)
    assert Can.ENTITY_BOUNDS_CONVEX not in can
    hull = Bounds(type=Bounds.TYPE_CONVEX_HULL, points=[Vector3(), Vector3(x=1.0), Vector3(y=1.0)])
    entities(swarm, UNSUPPORTED, bounds=hull)
    entities(swarm, UNSUPPORTED, bounds=Bounds(type=Bounds.TYPE_CONVEX_HULL))
    entities(swarm, Result.RESULT_OPERATION_FAILED, bounds=Bounds(type=Bounds.TYPE_SPHERE))
    assert entities(swarm, bounds=Bounds(type=Bounds.TYPE_EMPTY)) == ["Srobot1"]


def test_questions_about_the_world(swarm):
    world = ask(swarm, "GetCurrentWorld").world
    assert (world.name, resource_in(world).uri.endswith("world.sdf")) == (WORLD, True)
    assert WORLD in [world.name for world in ask(swarm, "GetAvailableWorlds").worlds]
    robots = [resource_in(entry).uri for entry in ask(swarm, "GetSpawnables").spawnables]
    assert ROBOT in robots
    assert "/mine" in ask(swarm, "GetSpawnables", None, sources=["/mine"]).result.error_message
    poses = ask(swarm, "GetNamedPoses").poses
    spawns = ask(swarm, "GetNamedPoses", tags=msg.TagsFilter(tags=["spawn"])).poses
    assert 0 < len(spawns) < len(poses)
    assert all("spawn" in pose.tags for pose in spawns)
    assert min(span(ask(swarm, "GetNamedPoseBounds", name=spawns[0].name).bounds)[:2]) > 0.5
    stations = ask(swarm, "GetNamedPoses", tags=msg.TagsFilter(tags=["station"])).poses
    assert ask(swarm, "GetNamedPoseBounds", name=stations[0].name).bounds.type == Bounds.TYPE_EMPTY
    ask(swarm, "GetNamedPoseBounds", Result.RESULT_NOT_FOUND, name="nowhere")


def test_several_come_at_once_and_each_is_answered_for(swarm):
    crates = [crate(f"crate_{x}", Pose(x, 3.0, PLACE.yaw)) for x in (3.0, 4.0)]
    taken = crate("crate_5", Pose(3.0, 3.0, 0.0))
    answer = ask(swarm, "SpawnEntities", 150, spawn_requests=[*crates, taken])
    codes = [result.result.result for result in answer.results]
    assert codes == [OK, OK, msg.SpawnResult.INVALID_POSE]
    assert [result.entity_name for result in answer.results] == ["crate_3.0", "crate_4.0", ""]
    assert ask(swarm, "SpawnEntities").results == []

    info = ask(swarm, "GetEntityInfo", entity="crate_3.0").info
    assert (info.category.category, list(info.tags)) == (0, ["static"])
    info = ask(swarm, "GetEntityInfo", entity="Srobot1").info
    assert (info.category.category, list(info.tags)) == (1, [ROBOT])
    ask(swarm, "GetEntityInfo", Result.RESULT_NOT_FOUND, entity="x")
    bounds = ask(swarm, "GetEntityBounds", entity="crate_3.0").bounds
    assert span(bounds) == pytest.approx([0.4, 0.2, 0.6])
    ask(swarm, "GetEntityBounds", Result.RESULT_NOT_FOUND, entity="x")

    assert entities(swarm, tags=msg.TagsFilter(tags=[ROBOT])) == ["Srobot1"]
    both = msg.TagsFilter(tags=[ROBOT, "static"], filter_mode=msg.TagsFilter.FILTER_MODE_ALL)
    assert entities(swarm, tags=both) == []
    # turned by 90 degrees, the crate reaches 0.1 m along x and 0.2 m along y
    for x, y, found in ((3.15, 3.0, []), (3.05, 3.0, ["crate_3.0"]), (3.0, 3.15, ["crate_3.0"])):
        corners = [Vector3(x=x + 0.02, y=y + 0.02, z=0.1), Vector3(x=x - 0.02, y=y - 0.02)]
        assert entities(swarm, bounds=Bounds(type=Bounds.TYPE_BOX, points=corners)) == found
    sphere = [Vector3(x=3.5, y=3.0, z=0.3), Vector3(x=0.45)]
    found = entities(swarm, bounds=Bounds(type=Bounds.TYPE_SPHERE, points=sphere))
    assert found == ["crate_3.0", "crate_4.0"]
    ask(swarm, "ResetSimulation", scope=srv.ResetSimulation.Request.SCOPE_SPAWNED)
    assert "crate_3.0" not in entities(swarm)


def simulate(swarm, client, steps, feedback=None):
    goal = action.SimulateSteps.Goal(steps=steps)
    handle = swarm.result_of(client.send_goal_async(goal, feedback_callback=feedback))
    assert handle.accepted
    return handle


def test_steps_as_an_action_with_feedback_after_each(swarm):
    client = ActionClient(swarm.node, action.SimulateSteps, "/sim/simulate_steps")
    swarm.spin_until(client.server_is_ready)
    result = swarm.result_of(simulate(swarm, client, 3).get_result_async()).result
    assert result.result.result == Result.RESULT_OPERATION_FAILED  # it is not paused
    paused = msg.SimulationState(state=msg.SimulationState.STATE_PAUSED)
    ask(swarm, "SetSimulationState", state=paused)
    assert ask(swarm, "GetSimulationState").state == paused
    seen = []
    handle = simulate(swarm, client, 3, lambda message: seen.append(message.feedback))
    result = swarm.result_of(handle.get_result_async()).result
    assert result.result.result == OK
    swarm.spin_until(lambda: len(seen) == 3)
    assert [(f.completed_steps, f.remaining_steps) for f in seen] == [(1, 2), (2, 1), (3, 0)]
    handle = simulate(swarm, client, 1_000_000)
    swarm.result_of(handle.cancel_goal_async())
    answer = swarm.result_of(handle.get_result_async())
    assert (answer.status, answer.result.result.result) == (5, Result.RESULT_OPERATION_FAILED)
    playing = msg.SimulationState(state=msg.SimulationState.STATE_PLAYING)
    ask(swarm, "SetSimulationState", state=playing)
    client.destroy()

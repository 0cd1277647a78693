"""Absurd requests to `/sim`: each is answered with its reason, and the world goes on."""

import math
import os

import pytest
from geometry_msgs.msg import Point
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from simulation_interfaces.msg import EntityCategory, Result, SimulationState
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntitiesStates,
    GetEntityState,
    ResetSimulation,
    SetEntityState,
    SetSimulationState,
    SpawnEntity,
    StepSimulation,
)

from swarm_common.middleware.ros_io import resource_in
from tests.graph.conftest import ROBOT

OK = Result.RESULT_OK
FAILED = Result.RESULT_OPERATION_FAILED
NAMES = SpawnEntity.Response
BOX = (
    '<sdf version="1.7"><model name="box"><link name="l"><collision name="c"><geometry><box>'
    "<size>0.3 0.3 0.3</size></box></geometry></collision></link></model></sdf>"
)
LONG = "x" * 1_000_000


ROBOTS = 1


@pytest.fixture(autouse=True)
def world_goes_on(swarm):
    """After each test, time runs and the one robot is still there."""
    yield
    before = swarm.sim_time()
    swarm.spin_until(lambda: swarm.sim_time() > before, 30.0)
    assert swarm.world.popen.poll() is None
    assert list(entities(swarm).entities) == ["Srobot1"]


def entities(swarm, kind=GetEntities, **filters):
    request = kind.Request()
    for name, value in filters.items():
        setattr(request.filters, name, value)
    name = "get_entities" if kind is GetEntities else "get_entities_states"
    return swarm.call(kind, f"/sim/{name}", request)


def spawn(swarm, uri="", text="", name="", frame="", xyz=(3.0, 3.0, 0.2), w=1.0, **fields):
    request = SpawnEntity.Request(name=name, **fields)
    resource = resource_in(request)
    resource.uri, resource.resource_string = uri, text
    request.initial_pose.header.frame_id = frame
    position = request.initial_pose.pose.position
    position.x, position.y, position.z = xyz
    request.initial_pose.pose.orientation.w = w
    return swarm.call(SpawnEntity, "/sim/spawn_entity", request)


def move(swarm, name="Srobot1", xyz=(0.0, 0.0, 0.0), w=1.0, twist=0.0, frame="map"):
    request = SetEntityState.Request(entity=name)
    state = request.state
    state.header.frame_id = frame
    state.pose.position.x, state.pose.position.y, state.pose.position.z = xyz
    state.pose.orientation.w = w
    state.twist.linear.x = twist
    return swarm.call(SetEntityState, "/sim/set_entity_state", request)


def check(answer, code, words=""):
    assert answer.result.result == code, answer
    assert words in answer.result.error_message
    assert len(answer.result.error_message) < 2000
    if code != OK:
        assert answer.result.error_message


@pytest.mark.parametrize("value", [1e308, -1e308, math.inf, math.nan, 1e9])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_places_out_of_this_world(swarm, value, axis):
    xyz = [3.0, 3.0, 0.2]
    xyz[axis] = value
    check(spawn(swarm, text=BOX, xyz=xyz), NAMES.INVALID_POSE)
    check(spawn(swarm, ROBOT, xyz=xyz), NAMES.INVALID_POSE)
    check(move(swarm, xyz=xyz), SetEntityState.Response.INVALID_POSE)


def test_turns_frames_and_twists_that_are_none(swarm):
    for w in (1e308, math.nan, 5.0):
        check(spawn(swarm, text=BOX, w=w), NAMES.INVALID_POSE)
        check(move(swarm, w=w), SetEntityState.Response.INVALID_POSE)
    check(spawn(swarm, text=BOX, frame="moon"), NAMES.INVALID_POSE, "moon")
    check(spawn(swarm, text=BOX, frame=LONG), FAILED, "frame_id")
    check(move(swarm, twist=math.nan), FAILED, "twist")


@pytest.mark.parametrize(
    ("filter_", "code"),
    [
        ("(" * 5000, FAILED), ("[" * 200, FAILED), ("(" * 200, FAILED), (LONG, FAILED),
        ("(a+)+$", OK), ("((a*)*)*b", OK), ("(.*)*(.*)*x", OK), ("(o|o)*(b|b)*(S|r)*!", OK),
        ("a{1000000}", FAILED), ("\\", FAILED), ("(?i)s", FAILED),
    ],
)  # fmt: skip
def test_filters(swarm, filter_, code):
    for kind in (GetEntities, GetEntitiesStates):
        check(entities(swarm, kind, filter=filter_), code)


def test_other_filters(swarm):
    many = [EntityCategory(category=255)] * 5000
    check(entities(swarm, categories=many), FAILED, "5000 entries")
    request = GetEntities.Request()
    request.filters.bounds.points = [Point(x=math.nan)] * 10
    check(swarm.call(GetEntities, "/sim/get_entities", request), FAILED, "finite")


@pytest.mark.parametrize("name", [LONG, "a\nb", "\x1b[2J", " ", "Srobot0", "Srobot65536"])
def test_names(swarm, name):
    check(spawn(swarm, text=BOX, name=name), NAMES.NAME_INVALID)
    check(spawn(swarm, ROBOT, name=name), NAMES.NAME_INVALID)
    for kind, service in (
        (DeleteEntity, "/sim/delete_entity"),
        (GetEntityState, "/sim/get_entity_state"),
    ):
        answer = swarm.call(kind, service, kind.Request(entity=name))
        assert answer.result.result in (FAILED, Result.RESULT_NOT_FOUND)
    check(spawn(swarm, ROBOT, name="Srobot1"), NAMES.NAME_NOT_UNIQUE, "Srobot1")


def test_models_that_are_none(swarm, tmp_path):
    fifo = tmp_path / "pipe.sdf"
    os.mkfifo(fifo)
    for uri in ("x" * 5000, "x" * 4096, str(fifo), f"file://{fifo}"):
        check(spawn(swarm, uri), NAMES.NO_RESOURCE)
    check(spawn(swarm, "file:///" + "y/" * 2000), NAMES.RESOURCE_PARSE_ERROR, "there is no file")
    check(spawn(swarm, "/dev/zero"), NAMES.NO_RESOURCE)
    link = '<link name="{}"><collision name="c"><geometry><sphere><radius>1</radius></sphere>'
    link += "</geometry></collision></link>"
    links = "".join(link.format(f"l{i}") for i in range(8000))
    text = f'<sdf version="1.7"><model name="m">{links}</model></sdf>'
    check(spawn(swarm, text=text), NAMES.RESOURCE_PARSE_ERROR, "8000 collision shapes")
    chain = "".join(f'<joint name="j{i}" type="fixed"/>' for i in range(20_000))
    text = f'<robot name="r"><link name="l"/>{chain}</robot>'
    check(spawn(swarm, text=text), NAMES.RESOURCE_PARSE_ERROR)
    path = tmp_path / "robot.urdf"
    path.write_text(text.replace("</robot>", chain.replace("j", "k") * 5 + "</robot>"))
    check(spawn(swarm, str(path)), NAMES.RESOURCE_PARSE_ERROR)
    check(spawn(swarm, text="x" * 1_000_001), NAMES.RESOURCE_PARSE_ERROR, "letters")
    check(spawn(swarm, text="<" * 100_000), NAMES.RESOURCE_PARSE_ERROR)


def test_the_world_goes_on_while_a_model_is_read(swarm, tmp_path):
    mesh = tmp_path / "pipe.stl"
    os.mkfifo(mesh)
    text = BOX.replace("<box><size>0.3 0.3 0.3</size></box>", f"<mesh><uri>{mesh}</uri></mesh>")
    path = tmp_path / "stuck.sdf"
    path.write_text(text, encoding="utf-8")
    client = swarm.node.create_client(SpawnEntity, "/sim/spawn_entity")
    assert client.wait_for_service(20.0)
    request = SpawnEntity.Request()
    resource_in(request).uri = str(path)
    future = client.call_async(request)
    before = swarm.sim_time()
    swarm.spin_until(lambda: future.done() or swarm.sim_time() > before + 2.0, 30.0)
    swarm.spin_until(future.done, 60.0)
    assert future.result().result.result != OK
    swarm.node.destroy_client(client)


def test_steps_states_scopes_and_speeds(swarm):
    def ask(kind, name, **fields):
        return swarm.call(kind, f"/sim/{name}", kind.Request(**fields))

    def state(value):
        return ask(
            SetSimulationState, "set_simulation_state", state=SimulationState(state=value)
        ).result.result

    for value in (0, 3, 77, 255):
        assert state(value) == Result.RESULT_FEATURE_UNSUPPORTED
    assert state(SimulationState.STATE_PAUSED) == OK
    for steps in (0, 2**63, 2**64 - 1):
        assert ask(StepSimulation, "step_simulation", steps=steps).result.result == FAILED
    check(ask(StepSimulation, "step_simulation", steps=3), OK)
    assert state(SimulationState.STATE_PLAYING) == OK
    for scope in (1, 8, 255):
        answer = ask(ResetSimulation, "reset_simulation", scope=scope)
        check(answer, Result.RESULT_FEATURE_UNSUPPORTED)
    for speed in (math.nan, math.inf, -1.0, 1e-300, 1e308):
        parameters = [Parameter("speed", value=speed).to_parameter_msg()]
        answer = swarm.call(
            SetParameters, "/sim/world/set_parameters", SetParameters.Request(parameters=parameters)
        )
        assert not answer.results[0].successful, speed


def test_a_burst_of_requests_is_answered(swarm):
    client = swarm.node.create_client(SpawnEntity, "/sim/spawn_entity")
    assert client.wait_for_service(20.0)
    request = SpawnEntity.Request()
    resource_in(request).resource_string = "<sdf"
    futures = []
    for _ in range(40):
        futures.append(client.call_async(request))
        swarm.spin(0.02)
    swarm.spin_until(lambda: all(future.done() for future in futures), 60.0)
    results = {future.result().result.result for future in futures}
    assert results <= {NAMES.RESOURCE_PARSE_ERROR, FAILED}
    swarm.node.destroy_client(client)

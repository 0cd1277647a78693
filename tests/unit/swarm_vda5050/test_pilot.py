"""What a robot's status means for a fleet control."""

import math

import msgspec
import pytest
from swarm_interfaces.msg import RobotStatus

from swarm_common.middleware.ros_io import ANY_HEADING, BACKWARDS
from swarm_common.model.records import LidarSpec, Pose, wrap_angle
from swarm_describe.robots.loading import load_robot
from swarm_vda5050.fine import MOST_MOVES
from swarm_vda5050.messages import AgvPosition, AgvVelocity
from swarm_vda5050.pilot import (
    DRIVE_SLACK,
    Pilot,
    _information,
    _sees_behind,
    _velocity,
    is_news,
)
from tests.fakes.fleet_orders import MAP, OF_3, Toy, action, node, order

NAMES = ("ann", "Srobot2")


@pytest.mark.parametrize(
    ("state", "detail", "others"),
    [
        ("waiting", "for ann, which drives", ["ann"]),
        ("yielding", "makes way for Srobot2, waits for ann, which stands", ["Srobot2", "ann"]),
        ("holding", "parked, waits for Srobot2: the narrow region ahead is full", ["Srobot2"]),
        ("holding", "parked, waits for room on the single lanes at dock", []),
        ("yielding", "leaves for others", []),
        ("waiting", "before an obstacle", []),
        ("driving", "", []),
    ],
)
def test_a_robot_that_waits_says_for_whom(state, detail, others):
    (info,) = _information(RobotStatus(state=state, detail=detail), NAMES)
    assert [each.reference_value for each in info.info_references or ()] == others
    assert info.info_type == state.upper()


def test_velocities_are_in_the_frame_of_the_robot():
    velocity = _velocity(Pose(0.0, 0.0, math.pi / 2), Pose(0.0, 1.0, math.pi / 2), 2.0)
    assert (velocity.vx, velocity.vy, velocity.omega) == (0.5, 0.0, 0.0)
    assert _velocity(Pose(0.0, 0.0, 3.0), Pose(0.0, 0.0, -3.0), 1.0).omega > 0.0


class Noting(Pilot):
    """A pilot without a robot: what it begins is written down."""

    def __init__(self, toy):
        self.vehicle, self._turn, self._goal, self.begun = toy.vehicle, None, (), []
        self._tick = self._fine_moves = 0
        self._task = self._ended = None
        self._is_fine_move, self._may_back = False, True
        self._velocity = AgvVelocity(vx=0.0, vy=0.0, omega=0.0)
        self._spec, self.robot = load_robot("turtlebot3_burger"), self

    def offers(self, *_):
        return True

    def _begin(self, _action, goal):
        self.begun.append(goal)

    @property
    def turns(self):
        return [goal.target_yaw for goal in self.begun]


@pytest.fixture
def at_heading():
    """A vehicle at a node with a heading that it does not have, and its pilot."""
    toy = Toy()
    toy.send(order([node(0), node(1, theta=1.5, allowedDeviationTheta=0.1)]))
    toy.pose = Pose(2.0, 0.0, 0.0)
    toy.sense()
    pilot = Noting(toy)
    pilot._end((("n1", 2),), True, "", False)
    assert pilot.turns == [1.5]
    return toy, pilot


def test_a_robot_that_made_way_in_the_midst_of_a_turn_turns_once_more(at_heading):
    toy, pilot = at_heading
    for yaw, rest in ((0.9, [0.6]), (1.49, [])):
        pilot.begun.clear()
        toy.pose = Pose(2.0, 0.0, yaw)
        toy.sense()
        pilot._end(pilot._goal, True, "", False)
        assert pilot.turns == pytest.approx(rest)
    assert toy.vehicle.last_node == ("n1", 2)


def test_a_node_whose_heading_is_missed_is_not_reached(at_heading):
    toy, pilot = at_heading
    pilot._end(pilot._goal, False, "no room to turn", False)
    assert toy.vehicle.last_node == ("n0", 0)
    assert toy.faults == ["DRIVING"]


def positioned(start, slip=0.0, reached=(True,), **place):
    """Let a robot that reached a node stand exactly; return its toy, and what it drove."""
    toy = Toy(OF_3)
    toy.send(order([node(0), node(1, action("finePositioning", "f"), **place)]))
    toy.pose = start
    toy.sense()
    toy.vehicle.arrive(("n1", 2))
    toy.wait(100.0)
    assert toy.done == {"f": "RUNNING"}
    pilot = Noting(toy)
    for is_reached in (*reached, *(True,) * 20):
        if (target := toy.vehicle.fine_target) is None:
            break
        count = len(pilot.begun)
        pilot._stand_exactly(target)
        for goal in pilot.begun[count:]:
            turn = getattr(goal, "target_yaw", 0.0)
            way = goal.target.x if hasattr(goal, "speed") else 0.0
            way -= math.copysign(DRIVE_SLACK, way) if way else 0.0
            x, y, yaw = toy.pose.x, toy.pose.y, toy.pose.yaw
            way *= 1.0 + slip
            toy.pose = Pose(x + way * math.cos(yaw), y + way * math.sin(yaw), yaw + turn)
            toy.wait(1.0)
            pilot._end((), is_reached, "a robot is in the way", False)
    return toy, pilot


@pytest.mark.parametrize("theta", [None, 0.0, -2.0])
@pytest.mark.parametrize("start", [Pose(1.8, 0.2, 0.0), Pose(2.2, 0.1, 1.0), Pose(2.0, -0.3, 3.0)])
@pytest.mark.parametrize("slip", [0.0, 0.3, -0.3])
def test_a_robot_stands_on_the_exact_pose_of_a_node(start, theta, slip):
    place = {} if theta is None else {"theta": theta}
    toy, pilot = positioned(start, slip, reached=(True, False), **place)
    assert toy.done == {"f": "FINISHED"}
    assert math.hypot(toy.pose.x - 2.0, toy.pose.y) <= 0.05
    assert theta is None or abs(wrap_angle(toy.pose.yaw - theta)) <= 0.05
    assert all(goal.speed * goal.target.x > 0.0 for goal in pilot.begun if hasattr(goal, "speed"))
    (state,) = toy.vehicle.action_states
    assert state.result_description.endswith("off")


def test_a_robot_that_cannot_stand_exactly_says_how_far_off_it_is():
    toy, pilot = positioned(Pose(1.7, 0.0, 0.0), reached=(False,) * 20, slip=-1.0)
    assert toy.done == {"f": "FAILED"}
    assert len(pilot.begun) == MOST_MOVES
    assert "0.300 m off: a robot is in the way" in toy.vehicle.errors[0].message


def test_fine_positioning_pauses_and_drives_alone():
    toy = Toy()
    content = order([node(0, action("finePositioning", "f", stationName="dock"))])
    toy.send(content)
    toy.wait(0.1)
    assert toy.vehicle.fine_target.x == 0.0
    toy.do("startPause", "p")
    assert toy.done["f"] == "PAUSED"
    assert toy.vehicle.fine_target is None
    toy.do("stopPause", "q")
    assert toy.vehicle.fine_target is not None
    toy.do("cancelOrder", "c")
    assert toy.done["f"] == "FAILED"
    for change in ({"blockingType": "NONE"}, {"actionType": "finePositioning"}):
        toy = Toy()
        content["nodes"][0]["actions"] = []
        target = content["nodes"][0]
        if "actionType" in change:
            content = order([node(0), node(1)])
            target = content["edges"][0]
        target["actions"] = [action("finePositioning", "f") | change]
        toy.send(content)
        assert toy.faults == ["UNKNOWN_ACTION"]


@pytest.mark.parametrize(("place", "tree"), [({}, ANY_HEADING), ({"theta": 1.5}, "")])
def test_a_robot_keeps_the_heading_in_which_it_arrives_at_a_node_without_theta(place, tree):
    toy = Toy()
    toy.send(order([node(0), node(1, **place)]))
    pilot = Noting(toy)
    pilot._send(toy.vehicle.leg)
    assert pilot.begun[0].behavior_tree == tree


@pytest.mark.parametrize(("orientation", "controller"), [(0.0, ""), (3.14, BACKWARDS)])
def test_an_edge_is_driven_backwards_once_the_robot_faces_against_it(orientation, controller):
    toy = Toy()
    content = order([node(0), node(1)])
    content["edges"][0]["orientation"] = orientation
    toy.send(content)
    pilot = Noting(toy)
    if controller:
        pilot._send(toy.vehicle.leg)
        assert abs(pilot.turns[0]) == pytest.approx(math.pi)
        pilot.begun.clear()
        toy.pose = Pose(0.0, 0.0, 3.1)
        toy.sense()
    pilot._send(toy.vehicle.leg)
    assert pilot.begun[0].controller_id == controller


@pytest.mark.parametrize(("rays", "sees"), [(360, True), (359, True), (270, False)])
def test_a_robot_that_does_not_see_behind_drives_no_edge_backwards(rays, sees):
    assert _sees_behind(LidarSpec(0.0, 0.0, 0.1, rays=rays)) is sees


def test_a_turn_between_two_looks_is_news():
    state = Toy().state()
    at = AgvPosition(x=0.0, y=0.0, theta=0.002, map_id=MAP, position_initialized=True)
    before = msgspec.structs.replace(state, agv_position=at)
    turned = msgspec.structs.replace(at, theta=1.48)
    after = msgspec.structs.replace(before, agv_position=turned)
    assert is_news(after, before)
    assert not is_news(after, after)

"""Any sequence of requests: nothing raises, each goal ends once, robots keep apart."""

import math

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from swarm_common.model.records import Pose
from swarm_common.model.sites import Sites
from swarm_nav.core.goals import Goal, GoalEnded, GoalKind
from tests.fakes.navigation import Squad, config, room
from tests.fakes.traffic import smallest_gap

HALL = room(6.0, 6.0, (2.6, 2.6, 3.4, 3.4))
STARTS = [Pose(1.0, 1.0, 0.0), Pose(5.0, 1.0, 2.0), Pose(1.0, 5.0, -1.0)]
SITES = Sites(
    stations={"dock": Pose(5.0, 5.0, 0.0)},
    circuits={"ring": ((1.5, 1.5), (4.5, 1.5), (4.5, 4.5), (1.5, 4.5))},
)
PLACES = [SITES.stations["dock"], *STARTS, Pose(3.0, 3.0, 0.0), Pose(9.0, 9.0, 0.0)]

places = st.sampled_from(PLACES)
goals = st.one_of(
    st.builds(Goal, kind=st.just(GoalKind.NAVIGATE), poses_map=st.tuples(places)),
    st.builds(
        Goal,
        kind=st.sampled_from((GoalKind.THROUGH, GoalKind.WAYPOINTS)),
        poses_map=st.lists(places, max_size=3).map(tuple),
    ),
    st.builds(
        Goal,
        kind=st.just(GoalKind.FOLLOW_PATH),
        is_reverse=st.booleans(),
        path_map=st.tuples(places, places).map(
            lambda ends: np.linspace((ends[0].x, ends[0].y), (ends[1].x, ends[1].y), 30)
        ),
    ),
    st.builds(Goal, kind=st.just(GoalKind.SPIN), angle=st.floats(-7.0, 7.0)),
    st.builds(
        Goal,
        kind=st.sampled_from((GoalKind.BACKUP, GoalKind.DRIVE_ON_HEADING)),
        distance=st.floats(0.0, 1.0),
        speed=st.floats(0.05, 0.3),
        duration=st.sampled_from((0.0, 3.0)),
    ),
    st.builds(Goal, kind=st.just(GoalKind.WAIT), duration=st.floats(0.0, 2.0)),
)
requests = st.one_of(
    goals.map(lambda goal: ("goal", goal)),
    st.tuples(st.just("cancel"), st.none()),
    st.tuples(st.sampled_from(("deactivate", "activate", "clear_costmap")), st.none()),
    st.tuples(st.just("deaf"), st.integers(1, 30)),
    st.tuples(st.just("slower"), st.floats(0.1, 0.26)),
)
steps = st.lists(
    st.tuples(st.integers(0, 2), requests, st.integers(0, 25)), min_size=3, max_size=14
)


def ask(squad, index, name, value, number):
    """Ask one robot for something; return whether it was a goal."""
    robot = squad.robots[index]
    if isinstance(value, Goal):
        fields = {f: getattr(value, f) for f in value.__slots__ if f != "goal_id"}
        robot.set_goal(Goal(goal_id=number, **fields))
        return True
    if name == "cancel":
        robot.services.cancel_goal()
    elif name == "deaf":
        squad.run(int(str(value)), deaf=[index])
    elif name == "slower":
        robot.services.reconfigure(config(max_vel_x=value))
    else:
        getattr(robot.services, name)()
    return False


@settings(
    max_examples=30, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)  # fmt: skip
@given(steps)
def test_any_sequence_of_requests_is_answered(sequence):
    squad = Squad(HALL, STARTS, sites=SITES)
    squad.run(20)
    sent: list[list[int]] = [[] for _ in STARTS]
    for number, (index, (name, value), pause) in enumerate(sequence):
        if ask(squad, index, name, value, number):
            sent[index].append(number)
        for _ in range(pause):
            squad.run(1)
            assert smallest_gap([b for b in squad.beacons if b is not None]) >= 0.5
    for index, robot in enumerate(squad.robots):
        robot.services.cancel_goal()
        robot.services.feedback()
        assert math.isfinite(robot.status().distance_remaining), index
    squad.run(2)
    for index, numbers in enumerate(sent):
        ended = [e.goal_id for e in squad.events[index] if isinstance(e, GoalEnded)]
        assert ended == numbers

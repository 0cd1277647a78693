"""Where a robot's result becomes the end of a goal, or another try."""

import pytest
from nav2_msgs.action import NavigateToPose

from swarm_nav.core.config import NavConfig
from swarm_nav.core.goals import PlanError
from swarm_nav.planning.planner import Planner
from swarm_nav.planning.search_kernels import WALL
from swarm_nav.planning.terrain import terrain_for
from swarm_run.robots.driver import is_for_good
from swarm_run.robots.task import TaskResult, why_not
from tests.fakes.navigation import room, waffle

ROOM = room(7.0, 4.0, (2.5, 0.0, 2.65, 2.8), (4.0, 0.0, 5.0, 4.0))
START = (1.0, 1.0)


def refusal(start, goal, shut):
    """Return why there is no way; `shut` are columns closed by obstacles."""
    parameters = NavConfig()
    terrain = terrain_for(
        ROOM, parameters.planner, parameters.costmap, waffle().circumscribed_radius
    )
    planner = Planner(terrain, parameters.planner)
    extra = planner.no_extra()
    extra[:, shut] = WALL
    with pytest.raises(PlanError) as error:
        planner.plan(start, goal, extra)
    return error.value


@pytest.mark.parametrize(
    ("start", "goal", "shut", "code", "wanted"),
    [
        ((-1.0, 1.0), START, slice(0), 203, True),
        (START, (9.0, 1.0), slice(0), 204, True),
        (START, (4.5, 1.0), slice(0), 206, True),
        (START, (6.0, 1.0), slice(0), 208, True),
        (START, (3.3, 1.0), slice(20, 22), 208, False),  # an obstacle may go away
        ((2.57, 1.0), START, slice(0), 205, False),  # a robot may lose its place, and find it
    ],
)
def test_what_the_map_alone_decides_is_not_tried_again(start, goal, shut, code, wanted):
    error = refusal(start, goal, shut)
    assert error.code == code
    result = NavigateToPose.Result(error_code=int(error.code), error_msg=str(error))
    assert is_for_good(result) is wanted


def test_a_refused_goal_is_tried_again_and_a_failed_task_says_why():
    assert not is_for_good(None)
    walled = NavigateToPose.Result(error_code=206, error_msg="the goal is occupied")
    assert why_not(walled, TaskResult.FAILED) == "error 206: the goal is occupied"
    assert why_not(NavigateToPose.Result(), TaskResult.CANCELED) == "canceled"

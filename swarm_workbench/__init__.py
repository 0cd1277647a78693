"""Swarms of mobile robots from Python; the names in `__all__` stay, everything else may change.

Imports every other package, and nobody of ours imports it. ROS is imported when a swarm of real
processes starts; the bench needs none.

Modules, lower ones first:

    observation_kernels  Bare numba kernels of what a policy sees of its neighbours and its way
    observation    What a policy sees, in an environment and on a robot
    ways           Shortest ways to goals, as a policy sees them
    reward         Named terms of a reward, and their weights
    frames         Pictures of environments
    steered        A robot that obeys twists inside space that it has reserved
    tables         A DataFrame where pandas is there
    trajectories   Where every robot was at each tick
    history        What the robots did and when
    report         Figures of a run
    world          Worlds: those that come along, and new ones
    place          Goals: a station, a pose or a pixel of the map
    goal           A goal on its way
    backend        What runs a swarm, seen from `Swarm`
    bench          All in this process, without ROS
    graph          A process for each robot, seen over ROS
    external       A robot that a node of one's own drives
    robot          One robot
    policy         A trained policy as a brain, with the extra `learn`
    picture        Map, paths and stations by matplotlib
    swarm          A swarm, on the bench or as processes
    arena          Worlds to learn in
    episodes       Starts, goals and people of an episode
    team           Episodes of all robots, in arrays
    vector         Many worlds at once
    gym            Environments to learn in, with the extra `learn`
    stable_baselines_compat  Them for stable-baselines3, with the extra `train`
    shortcuts      One call each: run a scenario, load a robot, start what swarm-up starts
"""

from __future__ import annotations

from swarm_bench.runs.scenario import Scenario
from swarm_common.model.errors import SwarmError
from swarm_common.model.records import Pose, Twist
from swarm_run.record.run_record import RunRecord as RunResult
from swarm_run.spec import RunSpec
from swarm_workbench.external import ExternalRobot, Sensed
from swarm_workbench.goal import Goal, GoalResult
from swarm_workbench.place import Pixel
from swarm_workbench.report import Report
from swarm_workbench.robot import Robot
from swarm_workbench.shortcuts import load_robot, run_scenario, start
from swarm_workbench.swarm import Swarm
from swarm_workbench.trajectories import Trajectories
from swarm_workbench.world import World, load_world

UpOptions = RunSpec  # its former name

__all__ = [
    "ExternalRobot",
    "Goal",
    "GoalResult",
    "Pixel",
    "Pose",
    "Report",
    "Robot",
    "RunResult",
    "RunSpec",
    "Scenario",
    "Sensed",
    "Swarm",
    "SwarmError",
    "Trajectories",
    "Twist",
    "World",
    "load_robot",
    "load_world",
    "run_scenario",
    "start",
]

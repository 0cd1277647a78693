"""Robots of a running swarm, over ROS: found, watched, driven.

What a module imports of its folder stands above it:

    teleop_keys   Keys of `swarm-teleop`, which count while they are pressed
    swarm_watch   Whether a swarm has a ROS domain, and whether the one that had it has ended
    delivery      A goal on its way to a server, over services that may lose a message
    discovery     Finds the running robots, and asks for their parameters over ROS
    robot_watch   Whether a robot that a program has sent somewhere is still there to answer
    goal_client   An action client that knows its goals' ids
    status_check  The door of the operator's side: which statuses are their robots', and of now
    task          One action goal on its way, from the request to the result
    client        `RobotCommander`: one robot of a swarm driven from Python
    driver        Takes one robot through its itinerary: goals out, results and status in

May import swarm_mission and swarm_common.
"""

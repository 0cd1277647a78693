"""Missions, and what takes robots through them.

What a module imports of its folder stands above it:

    robot_watch  Whether a robot that a program has sent somewhere is still there to answer
    swarm_watch  Whether a swarm has a ROS domain, and whether the one that had it has ended
    patience     How long a command waits for a swarm that it does not see yet
    delivery     A goal on its way to a server, over services that may lose a message
    state_log    What the robots did and when, a line for each change of state
    discovery    Finds the running robots, and asks for their parameters over ROS
    goal_client  An action client that knows its goals' ids
    status_check  The door of the operator's side: which statuses are their robots', and of now
    task         One action goal on its way, from the request to the result
    client       `RobotCommander`: one robot of a swarm driven from Python
    driver       Takes one robot through its itinerary: goals out, results and status in
    order_channel  The topic `/orders`, which is the radio of orders, and the lockstep on it
    goal_news    Tells swarm-up, and the state log, what becomes of goals
    order_party  A process that takes part in orders: its node, its signs of life and its loop
    station      Process of one station with orders, or of a dispatcher
    courier      Process of one robot's courier: bids for orders, and sends the robot
    runner       Mission process of `swarm-up`: drives all robots, or only watches

May import swarm_mission and swarm_common.
"""

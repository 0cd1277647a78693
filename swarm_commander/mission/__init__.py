"""Missions, and what takes robots through them.

What a module imports of its folder stands above it:

    state_log    What the robots did and when, a line for each change of state
    order_channel  The topic `/orders`, which is the radio of orders, and the lockstep on it
    order_party  A process that takes part in orders: its node, its signs of life and its loop
    station      Process of one station with orders, or of a dispatcher
    courier      Process of one robot's courier: bids for orders, and sends the robot
    runner       Mission process of `swarm-up`: drives all robots, or only watches

May import swarm_run, swarm_mission and swarm_common.
"""

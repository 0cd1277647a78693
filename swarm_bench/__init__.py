"""Bench: many seeded runs of the same brains in the same world, in one process without ROS.

May import swarm_sim, swarm_nav, swarm_commander's modules without ROS, and swarm_common; nobody
imports it.
"""

"""Builds ROS 2 interface packages from their definitions, without colcon or CMake.

Everybody may import `swarm_setup.build`; only that module imports from here.
"""

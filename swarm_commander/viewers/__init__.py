"""Configurations of RViz and Foxglove, and their windows.

What a module imports of its folder stands above it:

    foxglove     Foxglove layouts of a run: for one robot, and for the swarm
    rviz_config  What an RViz window shows: one robot, or the swarm, with models or without
    frame_relay  All robots' frames in one tree, for one RViz of the whole swarm
    window       Becomes a program with a window
    rviz         RViz for a run: its configuration files, and the commands that open them

May import swarm_common only.
"""

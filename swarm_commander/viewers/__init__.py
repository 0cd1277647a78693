"""Configurations of RViz and Foxglove, and their windows.

What a module imports of its folder stands above it:

    frame_relay  All robots' frames in one tree, for one RViz of the whole swarm
    rviz         RViz for a run: the commands that open its windows
    layouts      What the windows of RViz and Foxglove show, from the files in `layouts/`

May import swarm_common only.
"""

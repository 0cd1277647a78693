"""Builds the ROS 2 interface packages that PyPI lacks: the command `swarm-setup`."""

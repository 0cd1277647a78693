"""Runs the `ros2` command as `python -m swarm_ros2`."""

from swarm_ros2.cli import main

main()

"""The `ros2` command for machines without ros2cli.

It may import swarm_common; nobody imports it.
"""

"""The `ros2` command for machines without ros2cli; may import swarm_common and nobody imports it."""

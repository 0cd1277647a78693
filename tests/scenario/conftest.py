"""Real swarms in ROS domains of their own."""

from tests.fakes.real_swarm import start  # noqa: F401

"""Keeps every test's ROS graph on this host and out of the way of others."""

from __future__ import annotations

import os

from swarm_common import ros_env

ros_env.set_defaults()
# One domain per test run: two runs on one machine must not see each other.
os.environ["ROS_DOMAIN_ID"] = str(20 + os.getpid() % 80)

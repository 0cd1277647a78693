"""Keeps every test's ROS graph on this host and out of the way of others."""

from __future__ import annotations

import os

from swarm_common.middleware import ros_env
from tests.fakes import ros_domains

ros_env.set_defaults()
RESERVATION = ros_domains.unix_socket()
os.environ["ROS_DOMAIN_ID"] = str(ros_domains.of_this_run(RESERVATION))


def pytest_unconfigure() -> None:
    """Let others have the domain."""
    RESERVATION.close()

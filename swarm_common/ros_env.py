"""Environment of ROS 2 that every process of a swarm wants; set before rclpy is imported."""

from __future__ import annotations

import os
from pathlib import Path

PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
DISCOVERY_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
# What another terminal needs to see the same graph in the same way.
VARIABLES = ("ROS_DOMAIN_ID", DISCOVERY_RANGE, PROFILES)


def set_defaults() -> None:
    """Set what the user has not set.

    The graph stays on this host unless the user chose another range; then Fast DDS is left as it
    is, too. For one host the range is put into effect by our profile (fastdds.xml): it binds to
    the loopback interface only, while rmw_fastrtps would for LOCALHOST add shared memory, whose
    segments stay behind when a process is killed.
    """
    local = os.environ.get(DISCOVERY_RANGE, "LOCALHOST") == "LOCALHOST"
    own_profile = {PROFILES, "FASTDDS_DEFAULT_PROFILES_FILE", "ROS_DISCOVERY_SERVER"}
    if local and not own_profile & os.environ.keys():
        os.environ[DISCOVERY_RANGE] = "SYSTEM_DEFAULT"  # leaves the choice to the profile
        os.environ[PROFILES] = str(Path(__file__).resolve().parent / "fastdds.xml")
    elif local:
        os.environ[DISCOVERY_RANGE] = "LOCALHOST"

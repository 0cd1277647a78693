"""Environment of ROS 2 that every process of a swarm wants; set before rclpy is imported."""

from __future__ import annotations

import os
from pathlib import Path

PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
DISCOVERY_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
FIRST_PORT, DOMAIN_PORTS = 7400, 250  # UDP ports of DDSI-RTPS 9.6.1.1
NEWCOMERS = 16  # participant ids after those of the swarm
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


def announce_to_few(folder: Path, processes: int) -> None:
    """Let processes started from here announce themselves to few others.

    Robots need not know each other in DDS (their beacons go through the world's radio), and in
    large swarms that knowledge costs more than all their work. World and operator announce
    themselves to everybody, so robots find those anyway; here are added the ids that the next
    newcomers get, so that a tool without our environment finds the robots, too.

    Args:
        folder: Where the profile is written.
        processes: How many robot processes there will be.
    """
    own = Path(__file__).resolve().parent / "fastdds.xml"
    if os.environ.get(PROFILES) != str(own):
        return
    everybody = "<locator><udpv4><address>127.0.0.1</address></udpv4></locator>"
    ids = (0, *range(processes + 1, processes + 1 + NEWCOMERS))
    peers = "".join(
        f"<locator><udpv4><port>{_unicast_port(i)}</port><address>127.0.0.1</address></udpv4></locator>"
        for i in ids
    )
    profile = folder / "fastdds_robots.xml"
    text = own.read_text(encoding="utf-8")
    profile.write_text(text.replace(everybody, peers), encoding="utf-8")
    os.environ[PROFILES] = str(profile)


def _unicast_port(participant: int) -> int:
    """Return the port on which a participant listens for announcements (DDSI-RTPS 9.6.1.1)."""
    domain = int(os.environ.get("ROS_DOMAIN_ID", "0"))
    return FIRST_PORT + 10 + DOMAIN_PORTS * domain + 2 * participant

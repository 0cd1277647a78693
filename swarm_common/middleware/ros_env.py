"""Environment of ROS 2 that every process of a swarm wants; set before rclpy is imported.

Our own profile uses no shared memory. A profile of the user's, or another discovery range, may
bring it back; then a process that is killed, or ends at once, leaves its segments behind for ever:
`remove_abandoned` removes them.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import socket
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from swarm_common.model.errors import ConfigError
from swarm_common.process import home

FOLDER = Path("/dev/shm")
LOCKS = ("_el", "_sl")  # names of the files that a living process has locked: alone, or with others
MIN_AGE = 1.0  # [s] of a file; one that is younger may be about to be locked
PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
DISCOVERY_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
ENDPOINTS = "RMW_FASTRTPS_USE_QOS_FROM_XML"  # whether rmw_fastrtps takes the endpoints' profiles
FIRST_PORT, DOMAIN_PORTS = 7400, 250  # UDP ports of DDSI-RTPS 9.6.1.1
NEWCOMERS = 16  # participant ids after those of the swarm
MOST_PARTICIPANTS = 120  # of a domain; the ports of more are those of the next domain
PROCESSES = 3  # participants beside navigators and hubs: world, its gallery, mission
HUB_SIZE = 20  # robots that share a participant of world or mission in a large swarm
TERMINALS = 5  # participants that are left to the user
FEW_ROBOTS = 30  # up to here every participant may know everybody
LOCALHOST_ONLY = "ROS_LOCALHOST_ONLY"  # of older ROS 2; 1 prevails over the range, in Jazzy, too
SKIP_PROFILES = "SKIP_DEFAULT_XML_FILE"  # whether Fast DDS ignores a profile in the current folder
SECURITY, STRATEGY, KEYSTORE = (
    f"ROS_SECURITY_{name}" for name in ("ENABLE", "STRATEGY", "KEYSTORE")
)
# What another terminal needs to see the same graph in the same way.
VARIABLES = ("ROS_DOMAIN_ID", DISCOVERY_RANGE, LOCALHOST_ONLY, PROFILES, ENDPOINTS, SKIP_PROFILES)
FOREIGN = frozenset({PROFILES, "FASTDDS_DEFAULT_PROFILES_FILE", "ROS_DISCOVERY_SERVER"})
LOOPBACK = "127.0.0.1"
RANGES = ("LOCALHOST", "SUBNET", "SYSTEM_DEFAULT")  # OFF: no node would find another
_PROFILE = Path(__file__).resolve().parent / "fastdds.xml"
_MARK = 'profile_name="swarm"'
_ADDRESS = re.compile(r"<interfaceWhiteList>\s*<address>(?P<own>[0-9.]+)</address>")
_WRITER = re.compile(r"<data_writer [^>]*>")
_PEERS = re.compile(r"<initialPeersList>.*</initialPeersList>", re.DOTALL)


def set_defaults() -> None:
    """Set the variables that the user has not set.

    The graph stays on this host unless the user chose another range; then Fast DDS is left as it
    is, too. For one host the range is put into effect by our profile (fastdds.xml): it binds to
    the loopback interface only, while rmw_fastrtps would for LOCALHOST add shared memory, whose
    segments stay behind when a process is killed.

    Raises:
        ConfigError: If the range that the user chose is none, or lets no node find another; if
            this host cannot be reached from itself; if security is enforced without keys.
    """
    home.set_defaults(os.environ)
    _check_security()
    is_local = os.environ.get(LOCALHOST_ONLY) == "1"
    chosen = "LOCALHOST" if is_local else os.environ.get(DISCOVERY_RANGE) or "LOCALHOST"
    if chosen not in RANGES:
        why = "with it no node finds another; " if chosen == "OFF" else ""
        raise ConfigError(
            f"{DISCOVERY_RANGE} is '{chosen}': {why}unset it, or choose one of {', '.join(RANGES)}"
        )
    if chosen != "LOCALHOST":
        return
    if bound_address():  # ours is there already: inherited, or from an env.sh
        use_profile(os.environ[PROFILES])
    elif not FOREIGN & os.environ.keys():
        use_profile(str(_PROFILE))
    else:
        os.environ[DISCOVERY_RANGE] = "LOCALHOST"
    if bound_address() == LOOPBACK:
        _check_loopback()


def use_profile(path: str) -> None:
    """Activate one of our DDS profiles, with its settings of participants and endpoints."""
    os.environ[PROFILES] = path
    os.environ[DISCOVERY_RANGE] = "SYSTEM_DEFAULT"  # leaves the choice to the profile
    os.environ[ENDPOINTS] = "1"
    os.environ[SKIP_PROFILES] = "1"
    os.environ.pop(LOCALHOST_ONLY, None)


def _check_security() -> None:
    """Refuse what would end every process at its start."""
    is_enforced = os.environ.get(SECURITY) == "true" and os.environ.get(STRATEGY) == "Enforce"
    keys = os.environ.get(KEYSTORE, "")
    if is_enforced and not (keys and (Path(keys) / "enclaves").is_dir()):
        raise ConfigError(
            f"{SECURITY} is true and {STRATEGY} Enforce, but {KEYSTORE} ('{keys}') is no keystore:"
            f" unset {SECURITY}"
        )


def _check_loopback() -> None:
    """Refuse to start where the processes of this host cannot reach each other."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((LOOPBACK, FIRST_PORT))  # sends nothing
        except OSError as error:
            raise ConfigError(
                f"{LOOPBACK} cannot be reached ({error.strerror}), and with it no process the"
                " others: sudo ip link set lo up"
            ) from None


def is_profile_ours() -> bool:
    """Whether discovery is on this host and goes by our profile."""
    return os.environ.get(PROFILES) == str(_PROFILE)


def bound_address() -> str:
    """Return the address that all bind to by our profile in effect, or one made of it.

    Empty if the profile is the user's own, or there is none.
    """
    path = os.environ.get(PROFILES, "")
    if not path or not Path(path).is_file():
        return ""
    text = Path(path).read_text(encoding="utf-8")
    found = _ADDRESS.search(text)
    return found["own"] if found is not None and _MARK in text else ""


def is_large(robots: int) -> bool:
    """Whether a swarm is so large that its topics are spread (`participants`).

    Then navigators are told which participants to announce themselves to, and create rarely used
    servers only when a client appears.
    """
    return robots > FEW_ROBOTS and bool(bound_address())


def participants_of(robots: int, navigators: int) -> int:
    """Return the DDS participants of a large swarm."""
    return PROCESSES + 2 * -(-robots // HUB_SIZE) + navigators


def newcomer_ids(first_free: int) -> range:
    """Return the participant ids that the next newcomers get, from the first free one on.

    Never one whose port is in the next domain: Fast DDS connects participants of two domains once
    they know of each other. And at least one, as Fast DDS discards a profile, loopback and all,
    whose list of peers is empty.

    Args:
        first_free: Participant id that is free, as are all above it.
    """
    last = min(first_free + NEWCOMERS, MOST_PARTICIPANTS)
    return range(min(first_free, last - 1), last)


def write_profile(path: Path, ports: Iterable[int], first_free: int, host: str = "") -> None:
    """Write the profile of a process that announces itself to few others.

    Robots need not know each other in DDS (their beacons go through the world's radio), and in
    large swarms that knowledge costs more than all their work. Tools that search for all
    participants find the robots anyway; this adds the ids that the next newcomers get, so
    that a tool without our environment finds the robots, too.

    Args:
        first_free: Participant id that the next newcomer on this host will get.
        host: Address of those that the process needs, if they are on another host.
    """
    own = bound_address()
    newcomers = map(_unicast_port, newcomer_ids(first_free))
    needed = ((host or own, port) for port in ports)
    peers = "".join(
        f"<locator><udpv4><port>{port}</port><address>{address}</address></udpv4></locator>"
        for address, port in dict.fromkeys((*needed, *((own, port) for port in newcomers)))
    )
    text = Path(os.environ[PROFILES]).read_text(encoding="utf-8")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        _PEERS.sub(f"<initialPeersList>{peers}</initialPeersList>", text), encoding="utf-8"
    )


def use_quick_heartbeats(path: Path) -> None:
    """Let publishers of this process learn soon what their reliable listeners have.

    Fast DDS asks them every 3 s. Nothing changes where a profile of the user is in effect.

    Args:
        path: File to write the changed profile to.
    """
    if not bound_address():
        return
    times = "<times><heartbeatPeriod><nanosec>20000000</nanosec></heartbeatPeriod></times>"
    text = Path(os.environ[PROFILES]).read_text(encoding="utf-8")
    path.write_text(_WRITER.sub(lambda found: found[0] + times, text), encoding="utf-8")
    os.environ[PROFILES] = str(path)


def world_port() -> int:
    """Return the port of the first participant of the domain: in a small swarm, the world."""
    return _unicast_port(0)


def is_discovery_port(port: int) -> bool:
    """Whether a participant of this domain may listen for announcements on a UDP port."""
    offset = port - world_port()
    return 0 <= offset < 2 * MOST_PARTICIPANTS and offset % 2 == 0


def participant_id(port: int) -> int:
    """Return the id of the participant that listens for announcements on a port."""
    return (port - world_port()) // 2


def unicast_port(domain: int, participant: int) -> int:
    """Return the port on which a participant listens for announcements (DDSI-RTPS 9.6.1.1)."""
    return FIRST_PORT + 10 + DOMAIN_PORTS * domain + 2 * participant


def _unicast_port(participant: int) -> int:
    return unicast_port(int(os.environ.get("ROS_DOMAIN_ID") or "0"), participant)


def remove_abandoned(folder: Path = FOLDER) -> int:
    """Remove segments and ports that no living process has locked, like `fastdds shm clean`.

    What belongs to other users, or has gone meanwhile, is left alone.

    Returns:
        Number of files that were removed.
    """
    removed = 0
    names = {lock.name[: -len(end)] for end in LOCKS for lock in folder.glob(f"fastrtps_*{end}")}
    for name in names:
        with contextlib.suppress(OSError), contextlib.ExitStack() as held:
            locks = [path for end in LOCKS if (path := folder / f"{name}{end}").exists()]
            for path in locks:
                held.enter_context(_locked(path))
            for path in (folder / name, *locks, folder / f"sem.{name}_mutex"):
                path.unlink(missing_ok=True)
            removed += 1
    return removed


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock file."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        status = os.fstat(descriptor)
        if status.st_uid != os.geteuid() or time.time() - status.st_mtime < MIN_AGE:
            raise PermissionError(path)
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)

"""Is this machine fit for a swarm of some size? What would be in the way, and what to change.

`look` gathers the facts, `examine` judges them: a pure function of facts, size and domain.
`swarm-setup` builds what an environment needs once.
"""

from __future__ import annotations

import os
import resource
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated

import psutil
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from swarm_common.middleware.dds_profile import foreign_setting
from swarm_common.middleware.ros_env import (
    DISCOVERY_RANGE,
    DOMAIN_PORTS,
    FIRST_PORT,
    MOST_PARTICIPANTS,
    TERMINALS,
    participants_of,
)
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.process.compiled_code import is_compiled
from swarm_common.process.home import NAME, cache_base, can_be_written
from swarm_run.domain import domain_id
from swarm_run.packing import most_processes, parse_pack
from swarm_setup.build import ensure_interfaces, foreign_interfaces, stale_interfaces
from swarm_setup.compiled import ensure_compiled

MOST_ROBOTS = 1000
UNFIT = 1

doctor_app = typer.Typer(rich_markup_mode="rich")
CPU_PER_ROBOT = 0.02  # [s] of CPU per simulated second; 0.019 measured with 20 robots
WORLD_MEMORY = 350  # [MiB] of world, mission and the process that navigators are forked from
ROBOT_MEMORY = 40  # [MiB] of private memory per navigator
THREADS = 12  # of a navigator, middleware included
SHARED_MEMORY = 1.0  # [MiB] of /dev/shm per participant, where Fast DDS uses it
SHM = Path("/dev/shm")
PROCESS_FILES = 1024  # descriptors that a process may need
RECEIVE_BUFFER = 212_992  # [bytes] that a UDP socket may ask for, Linux's default
ROBOT_BUFFER = 20_000  # [bytes] of it for what one robot of a process is sent in a tick
OUR_RMW = "rmw_fastrtps_cpp"


class Level(Enum):
    """How bad a finding is."""

    GOOD = "ok"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True, slots=True)
class Finding:
    """The result of one check: the finding, and advice if it is not good."""

    level: Level
    subject: str
    found: str
    advice: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """The measured properties of the machine."""

    cpus: int
    load: float  # processes that wanted to run in the last minute, on average
    memory: float  # [MiB] that are available
    files: int  # limit of open files per process
    threads: int  # how many more threads the user may have
    receive_buffer: int  # [bytes] that a UDP socket may ask for
    ephemeral: int  # first port that the kernel gives to anybody
    ports: frozenset[int]  # UDP ports in use on this host
    rmw: str  # RMW_IMPLEMENTATION, empty if not set
    stale_interfaces: tuple[str, ...]  # interface packages that have to be built first
    has_compiler: bool  # whether a C++ compiler was found
    is_compiled: bool  # whether navigators run as compiled code
    cache: Path | None  # folder in which compiled kernels are kept; None if it is not writable
    shm: float = 0.0  # [MiB] free in /dev/shm, 0 without it
    # setting of the user's that replaces our DDS profile, which uses no /dev/shm; empty without one
    own_dds: str = ""
    # interface packages of somebody else, which are used, and where they are
    foreign_interfaces: tuple[str, ...] = ()
    wrong_interfaces: str = ""  # what is wrong with them; empty for nothing


def look(environment: Mapping[str, str] = os.environ) -> Facts:
    """Gather the facts."""
    processes = resource.getrlimit(resource.RLIMIT_NPROC)[0]
    most = min(
        processes if processes >= 0 else 1 << 30, int(_kernel("kernel/threads-max", "1073741824"))
    )
    running = sum(p.info["num_threads"] or 0 for p in psutil.process_iter(["num_threads"]))
    foreign: tuple[str, ...] = ()
    stale: tuple[str, ...] = ()
    wrong = ""
    try:
        foreign = tuple(f"{name} of {prefix}" for name, prefix in foreign_interfaces().items())
        stale = tuple(stale_interfaces())
    except SwarmError as error:
        wrong = str(error)
    kernels = Path(environment.get("NUMBA_CACHE_DIR") or cache_base() / NAME / "kernels")
    return Facts(
        cpus=len(os.sched_getaffinity(0)),
        load=os.getloadavg()[0],
        memory=psutil.virtual_memory().available / 2**20,
        files=resource.getrlimit(resource.RLIMIT_NOFILE)[0],
        threads=most - running,
        receive_buffer=int(_kernel("net/core/rmem_max", str(RECEIVE_BUFFER))),
        ephemeral=int(_kernel("net/ipv4/ip_local_port_range", "32768 60999").split()[0]),
        ports=frozenset(c.laddr.port for c in psutil.net_connections("udp4") if c.laddr),
        rmw=environment.get("RMW_IMPLEMENTATION", ""),
        stale_interfaces=stale,
        foreign_interfaces=foreign,
        wrong_interfaces=wrong,
        has_compiler=any(shutil.which(name) for name in ("g++", "c++", "clang++")),
        is_compiled=is_compiled(),
        cache=kernels if can_be_written(kernels) else None,
        shm=shutil.disk_usage(SHM).free / 2**20 if SHM.is_dir() else 0.0,
        own_dds=_own_dds(environment),
    )


def examine(facts: Facts, robots: int, domain: int, pack: int = 1) -> list[Finding]:
    """Judge facts for a swarm of `robots`, `pack` in a process, in a ROS domain."""
    processes = -(-robots // pack)
    participants = participants_of(robots, processes)
    return [
        _cpus(facts, robots),
        _memory(facts, robots),
        _at_least("open files", facts.files, PROCESS_FILES, "ulimit -n 4096"),
        _at_least(
            "threads",
            facts.threads,
            THREADS * processes + 100,
            "raise `ulimit -u`, or put several robots in a process: --pack 10",
        ),
        _participants(participants),
        _ports(facts, participants, domain),
        _buffer(facts, pack),
        _shm(facts, participants),
        _rmw(facts),
        _interfaces(facts),
        _navigators(facts),
        _cache(facts),
    ]


def _cpus(facts: Facts, robots: int) -> Finding:
    factor = facts.cpus / (CPU_PER_ROBOT * robots)
    found = f"{facts.cpus}, load {facts.load:.1f}: about {factor:.1f} x real time at most"
    if factor < 1.0:
        return Finding(Level.WARNING, "CPUs", found, "it will run slower than real time")
    if facts.load > 0.5 * facts.cpus:
        return Finding(Level.WARNING, "CPUs", found, "other programs want them, too")
    return Finding(Level.GOOD, "CPUs", found)


def _judged(
    is_good: bool, subject: str, found: str, advice: str, bad: Level = Level.WARNING
) -> Finding:
    """Return a finding; the advice is for one that is not good."""
    return Finding(Level.GOOD, subject, found) if is_good else Finding(bad, subject, found, advice)


def _memory(facts: Facts, robots: int) -> Finding:
    need = WORLD_MEMORY + ROBOT_MEMORY * robots
    found = f"{facts.memory:.0f} MiB available, about {need} MiB needed"
    most = max(0, int((facts.memory - WORLD_MEMORY) / ROBOT_MEMORY))
    advice = f"close programs, or start at most {most} robots"
    return _judged(facts.memory >= need, "memory", found, advice, Level.ERROR)


def _at_least(subject: str, found: int, need: int, advice: str) -> Finding:
    text = f"{found} possible, {need} needed"
    return _judged(found >= need, subject, text, advice, Level.ERROR)


def _participants(participants: int) -> Finding:
    found = f"{participants} needed of {MOST_PARTICIPANTS} that a host can have here"
    is_good = participants + TERMINALS <= MOST_PARTICIPANTS
    advice = "put several robots in a process: --pack 10"
    return _judged(is_good, "DDS participants", found, advice, Level.ERROR)


def _ports(facts: Facts, participants: int, domain: int) -> Finding:
    first = FIRST_PORT + DOMAIN_PORTS * domain
    last = first + 10 + 2 * min(MOST_PARTICIPANTS, participants + TERMINALS) - 1
    found = f"{first} to {last} for ROS domain {domain}"
    if last >= facts.ephemeral:
        lower = (facts.ephemeral - FIRST_PORT) // DOMAIN_PORTS - 1
        return Finding(
            Level.WARNING,
            "UDP ports",
            f"{found}; the kernel gives those from {facts.ephemeral} on to anybody",
            f"choose a lower domain: ROS_DOMAIN_ID={max(0, lower)}",
        )
    taken = sorted(port for port in facts.ports if first <= port <= last)
    if taken:
        return Finding(
            Level.WARNING,
            "UDP ports",
            f"{found}; {len(taken)} in use, {taken[0]} is the first",
            "another ROS graph is in this domain: stop it, or choose another ROS_DOMAIN_ID",
        )
    return Finding(Level.GOOD, "UDP ports", f"{found}, all free")


def _buffer(facts: Facts, pack: int) -> Finding:
    needed = max(RECEIVE_BUFFER, ROBOT_BUFFER * pack)
    found = f"{facts.receive_buffer} bytes per socket"
    advice = f"messages may get lost: sudo sysctl -w net.core.rmem_max={needed}"
    return _judged(facts.receive_buffer >= needed, "UDP buffer", found, advice)


def _shm(facts: Facts, participants: int) -> Finding:
    if not facts.own_dds:
        return Finding(Level.GOOD, str(SHM), "not used")
    need = SHARED_MEMORY * participants
    found = f"{facts.shm:.0f} MiB free; {facts.own_dds} may let Fast DDS use {need:.0f} MiB"
    advice = (
        f"unset {facts.own_dds}, or sudo mount -o remount,size={2 * need:.0f}M {SHM};"
        " with no ROS program running, rm /dev/shm/fast* removes what killed ones left"
    )
    return _judged(facts.shm >= need, str(SHM), found, advice)


def _rmw(facts: Facts) -> Finding:
    found = facts.rmw or f"{OUR_RMW} (the default)"
    advice = f"tested with {OUR_RMW} only: unset RMW_IMPLEMENTATION"
    return _judged(facts.rmw in ("", OUR_RMW), "RMW", found, advice)


def _interfaces(facts: Facts) -> Finding:
    if facts.wrong_interfaces:
        return Finding(Level.ERROR, "ROS interfaces", facts.wrong_interfaces)
    if not facts.stale_interfaces:
        found = "; ".join(["built", *facts.foreign_interfaces])
        return Finding(Level.GOOD, "ROS interfaces", found)
    found = f"not built yet: {', '.join(facts.stale_interfaces)}"
    if facts.has_compiler:
        return Finding(Level.WARNING, "ROS interfaces", found, "swarm-setup builds them")
    return Finding(
        Level.ERROR, "ROS interfaces", f"{found}; no C++ compiler", "install g++, then swarm-setup"
    )


def _navigators(facts: Facts) -> Finding:
    if facts.is_compiled:
        return Finding(Level.GOOD, "navigators", "compiled")
    found = "run as Python, which costs more: not compiled from these sources"
    return Finding(Level.WARNING, "navigators", found, "swarm-setup compiles them")


def _cache(facts: Facts) -> Finding:
    if facts.cache is not None:
        return Finding(Level.GOOD, "compiled kernels", f"kept in {facts.cache}")
    return Finding(
        Level.WARNING,
        "compiled kernels",
        "nowhere to keep them: each start compiles for a minute",
        "set NUMBA_CACHE_DIR to a folder that you may write",
    )


def _kernel(name: str, default: str) -> str:
    try:
        return (Path("/proc/sys") / name).read_text(encoding="ascii").strip()
    except OSError:
        return default


def _own_dds(environment: Mapping[str, str]) -> str:
    """Return the name of a variable by which the user replaces our DDS profile; empty if none."""
    name = foreign_setting(environment)
    if name:
        return name
    scope = environment.get(DISCOVERY_RANGE, "LOCALHOST")
    return "" if scope in ("LOCALHOST", "SYSTEM_DEFAULT") else DISCOVERY_RANGE


STYLES = {Level.GOOD: "green", Level.WARNING: "yellow", Level.ERROR: "bold red"}


@doctor_app.command(epilog="Example: swarm-doctor --swarm-size 100 --pack auto")
def doctor(
    swarm_size: Annotated[int, typer.Option(help="Number of robots to check for.")] = 100,
    pack: Annotated[str, typer.Option(help="Navigators per process, or auto.")] = "1",
) -> None:
    """Check whether this machine is fit for a swarm, and say what to change.

    Exit code: 0 fit (perhaps with warnings), 1 something is in the way, 2 bad input.
    """
    if not 1 <= swarm_size <= MOST_ROBOTS:
        raise ConfigError(f"--swarm-size is {swarm_size}; expected 1 to {MOST_ROBOTS}")
    packed = parse_pack(pack, swarm_size, most_processes(swarm_size))
    findings = examine(look(), swarm_size, domain_id(), packed)
    console = Console(markup=False)  # brackets in a name are none
    console.print(_table(findings, swarm_size))
    if any(finding.level is Level.ERROR for finding in findings):
        raise typer.Exit(UNFIT)


def _table(findings: list[Finding], swarm_size: int) -> Table:
    table = Table(title=f"This machine and {swarm_size} robots", title_justify="left")
    for column in ("", "what", "found", "to do"):
        table.add_column(column, overflow="fold")
    for finding in findings:
        level = Text(finding.level.value, style=STYLES[finding.level])
        table.add_row(level, finding.subject, finding.found, finding.advice)
    return table


setup_app = typer.Typer(rich_markup_mode="rich")


@setup_app.command(epilog="Example: swarm-setup")
def setup() -> None:
    """Install the ROS 2 interface packages that this environment lacks; compile the navigators.

    The other commands install the packages, too. Navigators whose sources have changed run as
    Python, slower and with the same results.
    """
    names = ensure_interfaces()
    done = f"ROS 2 interfaces installed: {', '.join(names)}"
    typer.echo(done if names else "ROS 2 interfaces are up to date", err=True)
    try:
        is_new = ensure_compiled()
    except SwarmError as error:
        typer.echo(f"warning: navigators run as Python, not compiled: {error}", err=True)
        return
    typer.echo("navigators compiled" if is_new else "compiled navigators are up to date", err=True)

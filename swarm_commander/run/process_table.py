"""Table of the processes of a run, one line each: who is wanted, from what, and what its end means.

`supervision` starts, watches, restarts, measures and stops what stands here, and knows no name.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Flag, auto
from pathlib import Path
from typing import Any

from swarm_commander.run.rundir import RunFolder
from swarm_commander.viewers.rviz import find_rviz, relay_command, rviz_command
from swarm_common.files.map_io import MAP_FILE
from swarm_common.model.records import Pose
from swarm_run.plan import RunPlan
from swarm_run.spec import MERGED

WORLD, HOST, RUNNER, RECORDER = "world", "navigators", "mission", "recorder"
STATION, COURIER, CENTRAL = "station", "courier", "central"
RVIZ, VIEWER, VDA5050 = "rviz", "viewer", "vda5050"
SERVER, CLIENT, DISTRIBUTOR = "server", "client", "distributor"  # of a run on several hosts
OPERATOR = "operator"  # group of swarm-up itself, too
MEETING = (WORLD, RUNNER)  # whose ports the navigators of a large swarm are told
QUIET = 30.0  # [s] of silence after which a process hangs that speaks every 2 s
BAG_FILE = "recording.mcap"

Configs = Mapping[str, dict[str, Any]]  # by the name of the process


@dataclass(frozen=True, slots=True)
class Start:
    """Facts that are known when the world is built."""

    plan: RunPlan
    folder: RunFolder
    homes_map: list[Pose]  # of all robots, broken ones included
    note: Callable[[str], None]  # tells the user something

    @property
    def map_file(self) -> Path:
        """The map: the user's, or the one that the world has drawn."""
        return self.plan.map or self.folder.trace / MAP_FILE

    @property
    def trace(self) -> dict[str, Any]:
        """Where a process writes its time series."""
        return {"trace_dir": str(self.folder.trace)}


class Trait(Flag):
    """Traits of a process; the run goes on without one that has none."""

    NONE = 0
    VITAL = auto()  # the run ends with it
    RESTARTED = auto()  # it is restarted when it dies
    MAY_END = auto()  # it may end by itself, with exit code 0
    TOLD = auto()  # it is told of robots that come, go, die and are silent
    TOLD_OWN = auto()  # of those in its configuration


VITAL, RESTARTED, MAY_END = Trait.VITAL, Trait.RESTARTED, Trait.MAY_END
TOLD, TOLD_OWN = Trait.TOLD, Trait.TOLD_OWN
LEADS = VITAL | RESTARTED  # robots do nothing without it


@dataclass(frozen=True, slots=True)
class Process:
    """One line of the table."""

    name: str  # name of the process; several of a line have a suffix, like `station_2`
    module: str  # Python module that it runs
    # returns the configuration of each process that is wanted when the world is built; None for one
    # that its kind of run starts itself
    wanted: Callable[[Start], Configs] | None = None
    group: str = ""  # group that CPU time and memory count to; empty: not measured
    traits: Trait = Trait.NONE  # what its end means, and what it hears
    silence: float = math.inf  # [s] of silence after which it hangs and is killed

    @property
    def may_refuse(self) -> bool:
        """Whether the run goes on if it refuses its input; who is to lead robots may not."""
        return not self.traits & (VITAL | RESTARTED)


def kind_of(name: str) -> str:
    """Return the name of a process's line in the table."""
    return name.split("_")[0]


def _mission(start: Start) -> Configs:
    return {RUNNER: start.plan.runner_config(start.homes_map) | start.trace}


def _recorder(start: Start) -> Configs:
    """The facts about the run are kept in the bag."""
    plan, spec = start.plan, start.plan.spec
    if not spec.record:
        return {}
    models = [member.model for member in plan.fleet.members]
    about = {
        "world": str(plan.world),
        "sites": str(plan.sites_path or ""),
        "robots": json.dumps(dict(zip(spec.robot_names, models, strict=True))),
        "mission": spec.mission or "",
        "seed": str(spec.seed),
    }
    return {
        RECORDER: {
            "path": str(start.folder.recording / BAG_FILE),
            "robots": spec.robot_names,
            "topics": spec.record_topics,
            "rate": spec.record_rate,
            "about": about,
            "awaited": start.plan.alive,
        }
    }


def _stations(start: Start) -> Configs:
    return {f"{STATION}_{each['number']}": each for each in start.plan.station_configs()}


def _couriers(start: Start) -> Configs:
    configs = start.plan.courier_configs(start.homes_map, start.map_file)
    return {f"{COURIER}_{each['number']}": each | start.trace for each in configs}


def _central(start: Start) -> Configs:
    if not start.plan.spec.coordination.has_centre:
        return {}
    params = start.folder.params / f"{start.plan.alive[0]}.yaml"
    return {CENTRAL: start.plan.central_config(start.map_file, params)}


def _rviz(start: Start) -> Configs:
    windows = start.plan.spec.rviz_windows
    program = find_rviz(start.note) if windows else None
    if program is None:
        return {}
    files = {name: start.folder.rviz / f"{name}.rviz" for name in windows}
    commands = {name: rviz_command(program, file, name) for name, file in files.items()}
    if MERGED in windows:
        commands["frames"] = relay_command()
    return {f"{RVIZ}_{name}": {"command": command} for name, command in commands.items()}


def _viewer(start: Start) -> Configs:
    spec = start.plan.spec
    if not spec.has_viewer:
        return {}
    title = f"{Path(spec.world).stem} · {start.folder.path.name}"
    return {VIEWER: {"host": spec.viewer_host, "port": spec.port, "title": title}}


def _vda5050(start: Start) -> Configs:
    is_wanted = start.plan.spec.fleet_control is not None
    return {VDA5050: start.plan.vda5050_config(start.map_file)} if is_wanted else {}


# Lines stand in the order of stopping. No tick follows when that begins: the recorder takes what
# was sent before its senders leave, who would take with them what it has not heard yet.
NAVIGATORS = "swarm_nav.launch.fork_server_main"
TABLE = (
    Process(RECORDER, "swarm_recording.recorder", _recorder, RECORDER),
    Process(WORLD, "swarm_sim.ros.node", None, "world", VITAL),
    Process(RUNNER, "swarm_commander.mission.runner", _mission, OPERATOR, LEADS | TOLD, QUIET),
    Process(HOST, NAVIGATORS, None, "navigators", LEADS),
    Process(SERVER, "swarm_commander.hosts.host_server", None, "", VITAL),
    Process(STATION, "swarm_commander.mission.station", _stations, OPERATOR, VITAL),
    Process(CENTRAL, "swarm_central.process", _central, CENTRAL, RESTARTED | TOLD, QUIET),
    Process(RVIZ, "swarm_commander.viewers.rviz", _rviz, "", MAY_END),
    Process(VIEWER, "swarm_view.process", _viewer, VIEWER),
    Process(VDA5050, "swarm_vda5050.process", _vda5050, VDA5050, TOLD),
    Process(COURIER, "swarm_commander.mission.courier", _couriers, OPERATOR, LEADS | TOLD_OWN),
)
ROBOTS_TABLE = (  # of a robots' host: the world is told before the navigators end
    Process(CLIENT, "swarm_commander.hosts.host_client", None, "", VITAL),
    Process(HOST, NAVIGATORS, None, "navigators", VITAL),
    Process(DISTRIBUTOR, "swarm_commander.hosts.distributor", None, "", VITAL),
)

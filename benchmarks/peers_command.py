"""The command `python -m benchmarks peers`: other simulators and ours on the same workload."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from benchmarks.app import benchmarks_app
from benchmarks.scale.plan import HARNESS, ScaleJob, plan_jobs
from benchmarks.scale.process import result_of, run_harness, run_program
from benchmarks.scale.result import ScaleResult
from benchmarks.scale.row import COMMON, ENDS, Column, ScaleRow, rows_of, scale_table
from benchmarks.scale.sweep import run_scale
from swarm_bench.runs.episode import RunOptions, build
from swarm_bench.suite.command import JsonLines, new_console
from swarm_bench.suite.selection import parse_sizes
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.records import FloatArray
from swarm_mission.itinerary import Itinerary
from swarm_sim.scene.section import GROUND_GAP, section_between
from swarm_sim.sdf.reader import load_world

WORKLOAD = "pillars"
ALL = "all"
WALL_LIMIT = 60.0  # [s] after which a slow peer's run ends
ROUND_CORNERS = 8  # from which an outline may be a round one
ROUND_ERROR = 0.01  # [m] by which its corners may differ in their distance from the middle


@dataclass(frozen=True, slots=True)
class PeerSystem:
    """A peer in one of its modes."""

    module: str  # in `benchmarks.peers`
    package: str  # on PyPI
    behavior: str  # mode, for the module
    includes: str  # what its figures pay for


PEERS: dict[str, PeerSystem] = {
    "navground HL": PeerSystem(
        "navground_run", "navground", "HL",
        "C++; kinematic differential drives, walls, perfect states of neighbours within 5 m; "
        "LiDAR 360 x 10 Hz is cast, but not used; no map, no planner, no ROS",
    ),
    "navground ORCA": PeerSystem("navground_run", "navground", "ORCA", "the same"),
    "ir-sim ORCA": PeerSystem(
        "irsim_run", "ir-sim", "orca",
        "Python; kinematic differential drives, LiDAR 360 x 10 Hz, collision check; ORCA does not "
        "know the walls; no map, no planner, no ROS",
    ),
    "pybullet-fleet": PeerSystem(
        "pybullet_fleet_run", "pybullet-fleet", "kinematic",
        "kinematic differential drives, collision check of pairs; no walls, no LiDAR, no "
        "avoidance, no ROS",
    ),
    "pybullet-fleet physics": PeerSystem(
        "pybullet_fleet_run", "pybullet-fleet", "physics",
        "one rigid disc per robot at 100 Hz with contacts; no wheels, walls, LiDAR, avoidance, ROS",
    ),
}  # fmt: skip
OURS_INCLUDES = (
    "`benchmarks scale --harness`: kinematic drives with acceleration limits, contacts with walls "
    "and robots, LiDAR 360 x 5 Hz, radio, and for each robot map, costmap, A*, DWA and traffic; "
    "no ROS"
)


def run_peer(job: ScaleJob, python: Path, machine: str) -> ScaleResult:
    """Run a peer once, with the interpreter of an environment that has it."""
    system = PEERS[job.system]
    with _import_path() as folder:
        script = Path(folder) / "benchmarks" / "peers" / f"{system.module}.py"
        command = (str(python), str(script), json.dumps(peer_job(job)))
        said, others = run_program(command, {"PYTHONPATH": folder, "PATH": "/usr/bin:/bin"})
    return result_of(job, said, others, version_of(python, system.package), machine)


def peer_job(job: ScaleJob) -> dict[str, Any]:
    """Return walls, starts and goals of our workload: those of our own robots."""
    options = RunOptions(scenario=dataclasses.replace(job.scenario, with_lidar=False),
                         robots=job.robots)  # fmt: skip
    stage = build(options)
    stage.world.close()
    spec = stage.world.specs[0]
    section = section_between(load_world(job.scenario.world).bodies, GROUND_GAP, spec.height)
    return {
        "behavior": PEERS[job.system].behavior,
        "seconds": job.seconds,
        "wall_limit": WALL_LIMIT,
        "starts": [[pose.x, pose.y, pose.yaw] for pose in stage.homes_map],
        "goals": [_goals(each) for each in stage.itineraries if isinstance(each, Itinerary)],
        **_obstacles(section.outlines()),
        "radius": spec.circumscribed_radius,
        "speed": spec.max_vel_x,
        "turn": spec.max_vel_theta,
        "wheel_separation": spec.wheel_separation,
        "rays": spec.lidar.rays,
        "range": spec.lidar.range_max,
    }


def _obstacles(outlines: Sequence[FloatArray]) -> dict[str, Any]:
    """Return polygons as `walls`, round ones as `pillars` (x, y, radius), which peers know, too."""
    walls, pillars = [], []
    for outline in outlines:
        center = outline.mean(axis=0)
        radii = np.hypot(*(outline - center).T)
        if len(outline) >= ROUND_CORNERS and np.ptp(radii) < ROUND_ERROR:
            pillars.append([*center.tolist(), float(radii.max())])
        else:
            walls.append(outline.tolist())
    return {"walls": walls, "pillars": pillars}


def _goals(itinerary: Itinerary) -> list[list[float]]:
    """Return where a robot has to go, one place after the other."""
    goals = []
    order = itinerary.start()
    while order is not None:
        goals.append([order.stop.pose_map.x, order.stop.pose_map.y])
        order = itinerary.on_end(True, 0)
    return goals


def check_python(python: Path) -> None:
    """Raise ConfigError if an interpreter does not run."""
    try:
        subprocess.run((str(python), "-c", "pass"), check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as cause:
        raise ConfigError(
            f"--python {python} does not run: {cause}; make an environment with "
            "python3 -m venv peers && peers/bin/pip install pybullet-fleet ir-sim pyrvo navground"
        ) from cause


def version_of(python: Path, package: str) -> str:
    """Return package and version in an environment."""
    code = f"import importlib.metadata as m; print(m.version({package!r}))"
    ended = subprocess.run((str(python), "-c", code), capture_output=True, text=True, check=False)
    return f"{package} {ended.stdout.strip()}" if not ended.returncode else package


@contextlib.contextmanager
def _import_path() -> Iterator[str]:
    """Yield a folder that has this package alone, so that nothing else of ours is imported."""
    with tempfile.TemporaryDirectory(prefix="swarm-peer-") as folder:
        (Path(folder) / "benchmarks").symlink_to(Path(__file__).resolve().parent)
        yield folder


@benchmarks_app.command()
def peers(
    python: Annotated[Path, typer.Option(help="Interpreter of the environment with the peers.")],
    robots: Annotated[str, typer.Option(help="Swarm sizes.")] = "1,5,20,50,100",
    names: Annotated[str, typer.Option("--peers", help="Names, comma-separated, or all.")] = ALL,
    repeats: Annotated[int, typer.Option(help="Runs of each size; tables have medians.")] = 3,
    seconds: Annotated[float, typer.Option(help="Simulated seconds of a run, at most.")] = 120.0,
    json_: JsonLines = None,
) -> None:
    """Measure other simulators and our harness: same hall, starts and goals.

    Peers run in an environment of their own, since some need older packages than we do:
    python3 -m venv peers; peers/bin/pip install pybullet-fleet ir-sim pyrvo navground
    """
    chosen = list(PEERS) if names == ALL else [name.strip() for name in names.split(",")]
    for name in chosen:
        if name not in PEERS:
            raise UnknownNameError("peer", name, PEERS)
    check_python(python)
    sizes = parse_sizes(robots)
    jobs = [
        job
        for system in (HARNESS, *chosen)
        for job in plan_jobs(system, sizes, repeats, workload=WORKLOAD, seconds=seconds)
    ]

    def run(job: ScaleJob, code: str, machine: str) -> ScaleResult:
        if job.system == HARNESS:
            return run_harness(job, code, machine)
        return run_peer(job, python, machine)

    console = new_console()
    results = run_scale(jobs, json_, console, run)
    rows = sorted(rows_of(results), key=lambda row: (row.first.robots, row.cpu_total))
    columns = {**_columns(), **_goal_column(sorted({job.robots for job in jobs}))}
    console.print(scale_table(rows, columns))
    console.print(_legend(rows), markup=False)


def _columns() -> dict[str, Column]:
    common = {name: COMMON[name] for name in ("start-up [s]", "real-time factor", "CPU [ms]")}
    return {
        "robots": COMMON["robots"],
        "system": lambda row: "ours" if row.first.system == HARNESS else row.first.system,
        **common,
        "RSS [MB]": lambda row: f"{row.memory('rss') or 0.0:.0f}",
        "simulated [s]": lambda row: f"{row.median(lambda run: run.sim_time) or 0.0:.0f}",
        **ENDS,
    }


def _goal_column(sizes: Sequence[int]) -> dict[str, Column]:
    """Return the column of goals reached, out of those of the mission."""
    asked = {}
    for job in plan_jobs(HARNESS, sizes, 1, workload=WORKLOAD):
        stage = build(RunOptions(scenario=job.scenario, robots=job.robots))
        stage.world.close()
        asked[job.robots] = sum(itinerary.total for itinerary in stage.itineraries)
    return {"goals": lambda row: f"{row.total('goals_reached')}/{asked[row.first.robots]}"}


def _legend(rows: Sequence[ScaleRow]) -> str:
    """Return what each system computes for its figures."""
    lines = [f"- ours: {OURS_INCLUDES}\n"]
    for name, system in PEERS.items():
        versions = {row.first.code for row in rows if row.first.system == name}
        if versions:
            lines.append(f"- {name} ({', '.join(sorted(versions))}): {system.includes}\n")
    return "What the figures pay for:\n\n" + "".join(lines)

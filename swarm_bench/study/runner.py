"""One run of the study with its faults."""

from __future__ import annotations

from swarm_bench.runs.episode import build
from swarm_bench.runs.harness import Harness
from swarm_bench.study.bounds import least_makespan
from swarm_bench.study.experiments import StudyRun
from swarm_bench.study.lines import StudyLine


def run_one(run: StudyRun) -> StudyLine:
    """Run once.

    Raises:
        SwarmError: If a file or a value is unusable.
    """
    options = run.options()
    stage = build(options)
    bound = None if run.cell.dead else least_makespan(options, stage)
    if stage.centre is not None:
        stage.centre.outage = run.outage()
    result = Harness(options, stage=stage, faults=run.faults()).run()
    centre = result.centre
    return StudyLine(
        experiment=run.experiment,
        cell=run.cell.name,
        method=run.method,
        seed=run.seed,
        goals_sent=result.goals_sent,
        goals_reached=result.goals_reached,
        robot_robot=result.robot_robot,
        robot_world=result.robot_world,
        makespan=None if result.makespan is None else round(result.makespan, 1),
        stopped=run.cell.seconds,
        bound=None if bound is None else round(bound, 1),
        cpu_ms_per_robot_second=round(result.cpu_ms_per_robot_second or 0.0, 3),
        tick_us_p99=None if result.tick_us_p99 is None else round(result.tick_us_p99, 1),
        longest_decision_ms=None if centre is None else round(centre["longest_decision_ms"], 1),
        bytes_per_robot_second=None
        if centre is None
        else round(centre["bytes_up_per_robot_second"] + centre["bytes_down_per_robot_second"], 1),
        trajectory_sha256=result.trajectory_sha256,
    )


def line_text(line: StudyLine) -> str:
    """Return one line about a run for the terminal."""
    end = f"{line.makespan:.1f} s" if line.makespan is not None else "not finished"
    return (
        f"{line.experiment}: {line.cell}, {line.method}, seed {line.seed}: "
        f"goals {line.goals_reached}/{line.goals_sent}, {end}, contacts {line.contacts}"
    )

"""A session of `swarm-up`: a checked plan from the run's folder to the report and the exit code."""

from __future__ import annotations

import os
import time
from datetime import datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.text import Text

from swarm_commander.run import process_table, terminal
from swarm_commander.run.local_run import LocalRun
from swarm_commander.run.own_navigators import Navigators, OwnNavigators
from swarm_commander.run.results.progress import Progress, summary_table
from swarm_commander.run.results.report import (
    RunTimes,
    compose_report,
    exit_code,
    load_verdict,
    write_report,
)
from swarm_commander.run.results.run_statistics import RunStatistics
from swarm_commander.run.rundir import RunFolder, create_run_folder, write_env_sh
from swarm_commander.run.supervision import Supervision
from swarm_commander.run.terminal import complain
from swarm_commander.viewers.layouts import write_foxglove, write_rviz
from swarm_common.middleware import ros_env
from swarm_common.middleware.secret import own_secret
from swarm_common.model.breaches import breach_lines, broken_lines, recording_lines, shortened
from swarm_common.model.engines import BULLET, NO_WHEELS, usual_engine
from swarm_common.model.run_words import SERIES_FIELDS
from swarm_common.process.home import log_to
from swarm_common.process.start import ensure_bytecode, own_packages
from swarm_run.command_line import COMPONENT_FAILED, OK
from swarm_run.domain import DomainLock, domain_id
from swarm_run.plan import RunPlan, check_plan
from swarm_run.spec import RunSpec
from swarm_setup.build import ensure_interfaces, interface_packages

COPIES = "inputs"  # of the user's files
SIGNALED = 128  # exit codes from here on are those of a signal


def start(spec: RunSpec, lock: DomainLock | None = None) -> int:
    """Run a swarm on this host until its end, as `swarm-up` does; return the exit code.

    Args:
        spec: Run, as files, flags or a program describe it.
        lock: Claim on this process's ROS domain; a new one without it.

    Raises:
        SwarmError: If a file or a value is unusable, or the ROS domain is in use.
    """
    plan = check_plan(spec)
    lock = lock or DomainLock(domain_id())  # from now on commands in other terminals wait for us
    ensure_interfaces()
    code = bring_up(plan, lock)
    if code < SIGNALED:
        ensure_bytecode([*own_packages(), *interface_packages()])  # for the next start
    return code


def bring_up(plan: RunPlan, lock: DomainLock) -> int:
    """Run a checked plan in the domain of `lock`, which is released; return the exit code."""
    ros_env.set_defaults()
    try:
        folder = create_run_folder(plan.spec.run_dir, datetime.now())
        plan = plan.with_copies(folder.configs / COPIES)
        log_to(folder.logs / "ros", os.environ)
        if plan.spec.bind:
            from swarm_commander.hosts.hosts_command import use_profile

            use_profile(folder, plan.spec.address, plan.spec.address)
        write_env_sh(folder, os.environ)
        console = terminal.console()
        statistics = RunStatistics.of(plan.spec.robot_names, plan.mission is not None)
        for name in set(plan.spec.robot_names) - set(plan.alive):
            statistics.robots[name].is_broken = True
        progress = Progress(console, statistics, time.monotonic)
        write_rviz(folder.rviz, plan.spec.robot_names)
        write_foxglove(folder.foxglove, plan.spec.robot_names)
        if not plan.names_engine and usual_engine() != BULLET:
            progress.note(NO_WHEELS)
        progress.phase("starting world")
        progress.start()
        run = Supervision(
            process_table.TABLE, folder, progress, statistics, restarts=plan.spec.restart
        )
        navigators = _navigators_of(plan, run)
        local = LocalRun(plan, run, navigators)
        run.serve(lock, navigators.obey)
        try:
            run.run(local, navigators)
        finally:
            progress.stop()
    finally:
        lock.release()
    code = _conclude(plan, run, local, console)
    folder.release()
    return code


def _conclude(plan: RunPlan, run: Supervision, local: LocalRun, console: Console) -> int:
    """Write the report, say how it went; return the exit code."""
    folder, statistics = run.folder, run.statistics
    verdict = run.verdict or load_verdict(folder.verdict)
    never_active = run.is_stopped_by_user and run.never_active
    if not verdict and not never_active:  # the other figures do not vouch for the run
        run.failures.append("there is no verdict: the world process did not live to give one")
    times = RunTimes(run.wall_time, run.active_after_wall, run.restarts.total)
    report = compose_report(plan.spec, statistics, verdict, run.usage, times)
    local.complete(report)
    must_finish = plan.spec.until_done and not run.is_stopped_by_user
    is_unfinished = must_finish and not statistics.is_done
    code = exit_code(report, is_unfinished=is_unfinished, component_failed=bool(run.failures))
    report |= {"exit_code": code, "failures": list(run.failures)}
    report["incidents"] = list(run.incidents)
    external = plan.spec.driven_by_users
    without = [name for name in plan.spec.robot_names if name not in plan.alive]
    report["broken"] = [name for name in without if name not in external]
    if external:
        report["external"] = list(external)
    report |= dict.fromkeys(SERIES_FIELDS) if never_active else _measures(folder, report)
    if problem := write_report(folder.report, report):
        code = COMPONENT_FAILED
        complain(problem)
    if never_active and code == OK:
        console.print("stopped before the robots drove")
        return SIGNALED + run.ending_signal
    console.print(summary_table(report, code))
    for line in broken_lines(report):
        console.print(line, highlight=False, soft_wrap=True)
    breaches = breach_lines(report["breaches"], had_to_finish=is_unfinished)
    for line in (*shortened(run.failures, "failures"), *recording_lines(report), *breaches):
        console.print(Text(line, style="red"), soft_wrap=True)
    if report["headline"]:
        console.print(Text(report["headline"], style="bold"), soft_wrap=True)
    written = _draw_page(folder, console) if plan.spec.report else folder.report
    console.print(f"report: {written}", highlight=False, soft_wrap=True)
    return code


def _navigators_of(plan: RunPlan, run: Supervision) -> Navigators:
    if not plan.spec.bind:
        return OwnNavigators(plan, run)
    from swarm_commander.hosts.hosted_navigators import HostedNavigators

    return HostedNavigators(plan, run, own_secret(os.environ))


def _measures(folder: RunFolder, report: dict[str, Any]) -> dict[str, Any]:
    """Return the report's fields that are worked out from the time series; null if that fails."""
    from swarm_report.headline import report_fields
    from swarm_report.run import RunData

    try:
        return report_fields(RunData(folder.path, report))
    except Exception as error:  # the figures that are known must not be lost with these
        complain(f"the time series could not be read: {error!r}")
        return dict.fromkeys(SERIES_FIELDS)


def _draw_page(folder: RunFolder, console: Console) -> Path:
    """Draw report.html; return it, or report.json if that fails."""
    try:
        from swarm_report.document import write_document  # matplotlib is slow to import

        return write_document(folder.path)
    except Exception as error:  # a plot must not cost a run its verdict
        console.print(Text(f"report.html could not be drawn: {error!r}", style="red"))
        return folder.report

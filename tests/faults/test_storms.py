"""Ten storms of five simulated minutes on twenty robots; each ends one component, too.

In all of them a navigator is killed or stopped every few seconds. After each: exit code and report
are true, and nothing is left: no process, no socket, no lock, no shared memory.
"""

import random
import signal
import time
from dataclasses import dataclass

import pytest

from tests.fakes.real_swarm import check_is_true

pytestmark = [pytest.mark.long, pytest.mark.timeout(3600)]

ROBOTS = 20
DURATION = 300.0  # [s] of simulated time
PERIOD = 20.0  # [s] of simulated time between two faults of navigators
STOPPED = 20.0  # [s] of wall time
FLAGS = ("--swarm-size", str(ROBOTS), "--mission", "loading_route", "--laps", "20")
FLAGS += ("--duration", str(DURATION), "--speed", "3", "--headless", "--no-report")


@dataclass(frozen=True)
class Storm:
    """What happens to a component at half time, and which exit codes are true then."""

    component: str
    number: int
    codes: tuple[int, ...]
    flags: tuple[str, ...] = ()

    @property
    def name(self):
        """For pytest."""
        return f"{self.component}-{signal.Signals(self.number).name}"


KILL, STOP = signal.SIGKILL, signal.SIGSTOP
STORMS = [
    Storm("world", KILL, (3,)),
    Storm("world", STOP, (3,)),
    Storm("world", signal.SIGTERM, (3,)),
    Storm("mission", KILL, (0,)),
    Storm("mission", STOP, (0,)),
    Storm("fork_server", KILL, (0,)),
    Storm("fork_server", STOP, (0,)),
    Storm("recorder", KILL, (3,), ("--record",)),
    Storm("viewer", KILL, (3,), ("--viewer", "--port", "0")),
    Storm("swarm-up", KILL, (-KILL,)),
]


@pytest.mark.parametrize("storm", STORMS, ids=lambda storm: storm.name)
def test_a_storm(start, storm):
    flags = [flag for flag in FLAGS if flag != "--headless" or storm.component != "viewer"]
    swarm = start(*flags, *storm.flags)
    rage(swarm, storm, random.Random(storm.name))
    code = swarm.wait_for_end()
    assert code in storm.codes, swarm.output
    if storm.component == "swarm-up":
        return  # nobody is left to write a report
    report = swarm.report()
    check_is_true(code, report)
    collisions = report["collisions"].values()
    assert not any(collisions), report["breaches"]["collisions"]
    assert report["goals"]["failed"] == 0
    assert report["restarts"] > 0
    if storm.component != "world":
        assert report["sim_time"] == pytest.approx(DURATION)


def rage(swarm, storm, rng):
    """Kill and stop until the run has ended."""
    swarm.wait_until(lambda: swarm.sim_time() > 0.0)
    due, is_component_due = PERIOD, True
    waking: list[tuple[float, str]] = []
    while swarm.is_running():
        time.sleep(0.2)
        now = swarm.sim_time()
        if now >= due:
            due += PERIOD
            robot = f"Srobot{rng.randint(1, ROBOTS)}"
            if swarm.send(robot, rng.choice((KILL, STOP))):
                waking.append((time.monotonic() + STOPPED, robot))
        for at, robot in [item for item in waking if time.monotonic() >= item[0]]:
            waking.remove((at, robot))
            swarm.send(robot, signal.SIGCONT)  # if it was not replaced meanwhile
        if is_component_due and now >= DURATION / 2.0:
            is_component_due = False
            assert swarm.send(storm.component, storm.number)


PHASES = {
    "the world has begun": lambda swarm: swarm.pid_of("world"),
    "the fork server imports": lambda swarm: swarm.pid_of("fork_server"),
    "navigators are forked": lambda swarm: swarm.navigators(),
    "the mission has begun": lambda swarm: swarm.pid_of("mission"),
    "robots are active": lambda swarm: "active 1/" in swarm.output or swarm.sim_time() > 0.0,
}
VICTIMS = ("world", "mission", "fork_server", "swarm-up", "Srobot2")


@pytest.mark.parametrize("victim", VICTIMS)
@pytest.mark.parametrize("phase", PHASES)
def test_a_start_that_loses_a_component(start, phase, victim):
    flags = ("--swarm-size", "3", "--mission", "loading_route", "--goals-per-robot", "1")
    swarm = start(*flags, "--until-done", "--speed", "max", "--headless", "--no-report")
    swarm.wait_until(lambda: PHASES[phase](swarm))
    if not swarm.send(victim, KILL):
        pytest.skip("it is not there yet")
    code = swarm.wait_for_end(600.0)
    if victim == "swarm-up":
        assert code == -KILL
        return
    report = swarm.report()
    check_is_true(code, report)
    assert code == (3 if victim == "world" else 0), swarm.output

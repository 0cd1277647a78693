"""Fork server of this host: starts its navigators, and again those that die or hang."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from swarm_commander.run.process_table import HOST
from swarm_commander.run.processes.navigators import NavigatorSupervisor
from swarm_commander.run.processes.restarts import MOST
from swarm_commander.run.processes.supervisor import describe_exit
from swarm_commander.run.supervision import Supervision
from swarm_common.process import messages as say
from swarm_common.process.lifetime import BEGINS_ANEW

FORGOTTEN = "was stopped until the others had forgotten it, and begins anew"


class HostForkServer(NavigatorSupervisor):
    """Restarts navigators that die or hang, and tells the user."""

    def __init__(self, run: Supervision, *, awaits_activity: bool = True) -> None:
        """Begin without robots.

        Args:
            awaits_activity: Whether a navigator becomes active by itself.
        """
        super().__init__(run.restarts, lambda command: run.tell(HOST, command), time.monotonic)
        self._run = run
        self._awaits_activity = awaits_activity

    def begin(self) -> None:
        """Start the fork server, which imports and compiles until it is released."""
        self._run.start(HOST, {}, "--wait")

    def release(self, config: dict[str, Any]) -> None:
        """Let the fork server start the navigators of a configuration."""
        self._run.configure(HOST, config)
        self._run.tell(HOST, say.Go())

    def restart_due(self, due: Sequence[str]) -> None:
        """Restart who is due; kill navigators, and a fork server, that hang."""
        run = self._run
        self.turn(due)
        for name in due:
            if name in run.statistics.robots:
                run.statistics.robots[name].restarts += 1
        for name in self.overdue() if self._awaits_activity else ():
            run.record_incident(f"{name} did not become active again: it hangs and is killed")
            self.kill(name)
        if self.is_fork_server_deaf() and run.is_running(HOST):
            run.record_incident(f"the {HOST} process does not start anybody: it is killed")
            self.on_fork_server_end()
            run.kill(HOST)

    def kill_stragglers(self, missing: Sequence[str]) -> None:
        """Kill navigators that hang at the start; they are restarted like any that die.

        Args:
            missing: Robots that are not active.
        """
        run = self._run
        if run.restarts.is_allowed:
            for name in self.stragglers(run.statistics.active, missing):
                run.record_incident(f"{name} did not become active with the others: it hangs")
                self.kill(name)

    def on_died(self, event: say.NavigatorDied) -> bool:
        """Restart a dead navigator if that may help; return whether it will be restarted."""
        name, begins_anew = event.robot, event.returncode == BEGINS_ANEW
        how = f"died: {describe_exit(event.returncode)}"
        message = f"{name} {FORGOTTEN if begins_anew else how}"
        pause = self.on_death(name, begins_anew=begins_anew)
        where = f"its log is in {self._run.folder.logs}"
        if pause is None:
            is_often = self._run.restarts.is_allowed
            often = f" more than {MOST} times; it stays down" if is_often else ""
            self._run.fail(f"{message}{often}; {where}")
            return False
        self._run.record_incident(f"{message}; it is restarted in {pause:g} s; {where}")
        return True

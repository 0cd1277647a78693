"""The fork server, with one navigator that fails: `python -m tests.fakes.failing_host CONFIG`.

That one is Srobot2, and it does so when its process gets SIGUSR1.
"""

import os
import signal
import sys

from swarm_nav.launch import fork_server_main, navigator_process
from swarm_nav.ros.inputs import TickInput
from swarm_nav.ros.node import NavigatorNode

ROBOT = "Srobot2"
signals: list[int] = []


class FailingNode(NavigatorNode):
    """A navigator with a bug."""

    def _step(self, observed: TickInput | None) -> None:
        if signals and self._settings.name == ROBOT:
            raise ZeroDivisionError("the bug")
        super()._step(observed)


if __name__ == "__main__":
    signal.signal(signal.SIGUSR1, lambda number, _: signals.append(number))
    navigator_process.NavigatorNode = FailingNode
    code = fork_server_main.main()
    sys.stdout.flush()
    os._exit(code)

"""The process of the fork server.

python -m swarm_nav.launch.fork_server_main CONFIG.json [--event-fd N] [--control-fd M]

Imports everything and warms the kernels once, then forks one process per robot (or per pack of
robots). A fork costs almost nothing; a fresh interpreter costs a CPU second and 60 MB. It has one
thread, whatever it imports: see `quick_start`.
"""

from __future__ import annotations

import os
import signal
import sys
import traceback

from swarm_common.middleware import ros_env
from swarm_common.model.errors import SwarmError
from swarm_common.process.compile_watch import watched
from swarm_common.process.messages import Compiling, ConditionsChecked, Ready, Refused
from swarm_common.process.pipes import EventWriter, child_options
from swarm_common.process.quick_start import load_numba, without_collector, without_threads

with without_threads():  # which OpenBLAS and rclpy would start
    from swarm_nav.launch.fork_server import ForkServer
    from swarm_nav.launch.process_groups import Grouping
    from swarm_nav.launch.warm_up import warm_up
    from swarm_nav.ros.types import load_type_supports

KERNELS = ("swarm_nav", "swarm_common")  # whose kernels a navigator needs


def _prepare(events: EventWriter) -> None:
    """Do the work once that every child would have to do."""
    with without_collector(), without_threads():
        load_numba()
        load_type_supports()
        with watched(lambda *counts: events.write(Compiling(*counts)), KERNELS):
            warm_up()


def main(arguments: list[str] | None = None) -> int:
    """Run all navigators until told to stop.

    Args:
        arguments: Arguments of the command line; None for this process's own.

    Returns:
        The exit code: 0, or 2 for an unusable configuration.
    """
    options = child_options("Navigators of a swarm", arguments)
    ros_env.set_defaults()
    events = EventWriter(options.event_fd)
    fork_server = ForkServer(events)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: fork_server.stop())
    if options.wait:
        _prepare(events)
        if not fork_server.wait_for_go(options.control_fd):
            return 0
    elif options.control_fd is not None:
        fork_server.listen(options.control_fd)
    try:
        grouping = Grouping(options.config)
    except SwarmError as error:
        events.write(Refused(str(error)))
        sys.stderr.write(f"{error}\n")
        return 2
    if not options.wait:
        _prepare(events)
    with without_collector():  # what the children share must not be touched by it
        found = grouping.share_terrain()
    if found is not None:
        events.write(
            ConditionsChecked(
                text=str(found),
                guaranteed=found.is_guaranteed,
                places=found.places,
                robots=found.robots,
                findings=list(found.findings),
            )
        )
    for group in grouping.groups:
        fork_server.fork(group, grouping.log_dir)
    events.write(Ready())
    fork_server.watch(grouping)
    return 0


if __name__ == "__main__":
    code = 1
    try:
        code = main()
    except SystemExit as end:  # argparse's
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # the interpreter's own end takes seconds with numba in it

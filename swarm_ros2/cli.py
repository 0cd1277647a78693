"""Entry point of the `ros2` command."""

from __future__ import annotations

import signal


def main() -> None:
    """Run the command; SIGINT ends it without a traceback while modules are imported."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from swarm_ros2 import command_line

    command_line.main()

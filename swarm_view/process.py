"""The viewer's process: `python -m swarm_view.process CONFIG.json`; started by swarm-up."""

from __future__ import annotations

import json
import logging
import sys

from swarm_common.model.errors import SwarmError
from swarm_common.process.messages import VIEWER, Refused, ViewerOpened
from swarm_common.process.pipes import EventWriter, MessageReader, child_options
from swarm_view.live import leave, open_node, serve_live
from swarm_view.server.server import Server


def main(arguments: list[str] | None = None) -> int:
    """Serve the view until told to stop; returns the exit code."""
    options = child_options("Viewer of a swarm", arguments)
    logging.basicConfig(level=logging.WARNING)
    events = EventWriter(options.event_fd)
    config = json.loads(options.config.read_text(encoding="utf-8"))
    try:
        server = Server(config["host"], config["port"])
    except SwarmError as error:
        events.write(Refused(str(error)))
        sys.stderr.write(f"{error}\n")
        return 2
    events.write(ViewerOpened(server.url()))
    commands = MessageReader(options.control_fd, VIEWER)
    serve_live(server, open_node(), commands.read)
    return 0


if __name__ == "__main__":
    leave(main())

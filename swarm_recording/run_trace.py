"""Trace that every run leaves for its replay: poses, states and the scene, in small MCAP files.

Each process that knows something writes a file of its own; a bag of several files is read as one.
"""

from __future__ import annotations

import logging
import struct
from pathlib import Path

from mcap.writer import CompressionType

from swarm_common.middleware.topic_table import WORLD_TOPICS, Topic
from swarm_common.model.records import CONTROL_PERIOD
from swarm_recording.mcap_file import NANOSECONDS
from swarm_recording.tape import Tape

FOLDER = "replay"  # within the folder of the trace
LOG = logging.getLogger(__name__)
TOPICS = {topic.name: topic for topic in WORLD_TOPICS}  # of the world, by name


class RunTrace:
    """One of the files; a full disk ends it with a word in the log, not the run."""

    def __init__(self, trace: Path, world: str = "") -> None:
        """Begin the next file that is free in a trace's folder.

        Args:
            world: Name or path of the run's world, kept in the file; empty if it is not known.
        """
        about = {"world": world} if world else {}
        self._tape: Tape | None = None
        folder = trace / FOLDER
        try:
            folder.mkdir(exist_ok=True)
            path = next(
                path for n in range(1000) if not (path := folder / f"run_{n}.mcap").exists()
            )
            path.touch()
            self._tape = Tape(path, about, compression=CompressionType.ZSTD, has_metadata=False)
        except OSError as error:
            self._give_up(error)

    def write(self, topic: Topic, tick: int, data: bytes) -> None:
        """Keep a serialized message of a control tick."""
        if self._tape is None:
            return
        try:
            self._tape.add_topic(topic)
            self._tape.write(topic.name, round(tick * CONTROL_PERIOD * NANOSECONDS), data)
            self._tape.save_if_due()
        except (OSError, struct.error) as error:
            self._give_up(error)

    def close(self) -> None:
        """Save and close."""
        tape, self._tape = self._tape, None
        if tape is None:
            return
        try:
            tape.close()
        except OSError as error:
            self._give_up(error)

    def _give_up(self, error: Exception) -> None:
        self._tape = None
        LOG.warning("the run cannot be replayed from here on: %s", error)

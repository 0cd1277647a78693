"""A bag in the making: an MCAP file (profile ros2) that opens at every moment.

An MCAP file ends with a summary that most readers need, and with a footer that tells where the
summary begins. Each save puts a chunk and a new summary in the place of the old one. A recorder may
be killed in the midst of that, so the old summary is copied behind the new one first (`_Sheet`).
"""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Mapping
from pathlib import Path

import yaml
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from swarm_common.middleware.topic_table import Topic
from swarm_recording.schema import schema_text, type_hash

METADATA = "metadata.yaml"
LIBRARY = "swarm-workbench"
LOST = "swarm_lost"  # metadata: number of messages that were sent and are not in the file, by topic
MIN_PERIOD, MAX_PERIOD = 1.0, 5.0  # [s] of wall time between two writes
CHUNK_SIZE = 4 * 2**20  # [bytes] before compression
FOOTER = struct.Struct("<BQQQI8s")  # code, length, start of the summary, of offsets, CRC, magic
FOOTER_LENGTH = 20  # [bytes] between its own field and the magic
PAGE = 4096  # [bytes]


class _Sheet:
    """The file below the writer: collects writes, and puts them on disk as if at once.

    A process that is killed ends a write between two pages of memory, never within one. So a write
    within one page, a truncation and a renaming happen or do not happen.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._draft = path, path.with_name(f".{path.name}.draft")
        flags = os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC
        self._descriptor = os.open(self._draft, flags, 0o644)
        self._start = 0
        self._pending = bytearray()
        self._tail = b""  # the summary, which is on disk from `_start` on

    def write(self, data: bytes) -> int:
        self._pending += data
        return len(data)

    def tell(self) -> int:
        return self._start + len(self._pending)

    def flush(self) -> None:
        """Keep collecting: only `lay_down` writes."""

    def lay_down(self, keep: int) -> None:
        """Write everything; later writes begin at `keep` and overwrite the rest.

        Raises:
            OSError: If there is no room; the file is as it was then.
        """
        content = bytes(self._pending)
        try:
            if self._tail:
                self._set_aside(self._start + len(content))
            self._put(content, self._start)
            if not self._tail:
                self._draft.replace(self._path)
        except OSError:
            self._put(self._tail, self._start)  # which has room: it was there
            os.ftruncate(self._descriptor, self._start + len(self._tail))
            raise
        os.ftruncate(self._descriptor, self._start + len(content))
        self._tail = content[keep - self._start :]
        self._start, self._pending = keep, bytearray()

    def _set_aside(self, end: int) -> None:
        """Let the file end with a copy of its summary, behind the old one and the byte `end`."""
        old = FOOTER.unpack(self._tail[-FOOTER.size :])[2]
        summary = self._tail[old - self._start : -FOOTER.size]
        end = max(end, self._start + len(self._tail)) + len(summary)
        footer = -(-end // PAGE) * PAGE
        copy = footer - len(summary)
        self._put(_footer(old), footer)
        self._put(summary, copy)
        self._put(_footer(copy), footer)

    def _put(self, data: bytes, at: int) -> None:
        """Write; a call may write less than it is given, and fail next time."""
        while data:
            count = os.pwrite(self._descriptor, data, at)
            at, data = at + count, data[count:]

    def close(self) -> None:
        os.close(self._descriptor)


def _footer(summary: int) -> bytes:
    return FOOTER.pack(Opcode.FOOTER, FOOTER_LENGTH, summary, 0, 0, MCAP0_MAGIC)


class Tape:
    """Writes messages of ROS topics.

    Attributes:
        counts: Messages so far, by topic.
    """

    def __init__(
        self,
        path: Path,
        about: Mapping[str, str],
        *,
        compression: CompressionType = CompressionType.LZ4,
        has_metadata: bool = True,
    ) -> None:
        """Begin a file.

        Args:
            path: Path of the file, which is there after the first save; replaced if it exists.
            about: Facts about the run, kept in the file as metadata ``swarm``.
            has_metadata: Whether rosbag2's metadata.yaml is written beside it.

        Raises:
            OSError: If it cannot be written.
        """
        self.counts: dict[str, int] = {}
        self._sheet = _Sheet(path)
        # Without offsets of the summary's parts, `finish` can be repeated.
        self._writer = Writer(
            self._sheet,  # type: ignore[arg-type]
            chunk_size=CHUNK_SIZE,
            compression=compression,
            use_summary_offsets=False,
        )
        self._writer.start(profile="ros2", library=LIBRARY)
        self._writer.add_metadata("swarm", dict(about))
        self._has_metadata = has_metadata
        self._path, self._topics = path, dict[str, Topic]()
        self._span = (0, 0)  # [ns] first and last message
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._latest = 0.0
        self._summary_size = 0
        self._size = 0

    def add_topic(self, topic: Topic) -> None:
        """Announce a topic, also while others are being written; again is no harm.

        Raises:
            ConfigError: If the definition of its type is not installed.
        """
        if topic.name in self._channels:
            return
        if topic.type not in self._schemas:
            text = schema_text(topic.type).encode()
            self._schemas[topic.type] = self._writer.register_schema(topic.type, "ros2msg", text)
        metadata = {"offered_qos_profiles": quality_text(topic)}
        schema = self._schemas[topic.type]
        self._channels[topic.name] = self._writer.register_channel(
            topic.name, "cdr", schema, metadata
        )
        self.counts[topic.name] = 0
        self._topics[topic.name] = topic

    def write(self, topic: str, stamp: int, data: bytes) -> None:
        """Add a serialized message with its time [ns]; it is on disk after the next `save`."""
        self._writer.add_message(
            self._channels[topic], stamp, data, stamp, sequence=self.counts[topic]
        )
        is_first = not any(self.counts.values())
        self._span = (
            (stamp, stamp) if is_first else (min(self._span[0], stamp), max(self._span[1], stamp))
        )
        self.counts[topic] += 1
        self._size += len(data)

    def save_if_due(self) -> None:
        """Save every few seconds: rarely enough that summaries cost little."""
        if not self._topics:
            return
        waited = time.monotonic() - self._latest
        if waited > MAX_PERIOD or (waited > MIN_PERIOD and self._size > self._summary_size):
            self.save()

    def save(self) -> None:
        """Write everything so far, so that the file is complete."""
        self._writer.flush()  # type: ignore[no-untyped-call]
        end = self._sheet.tell()
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._summary_size = self._sheet.tell() - end
        self._sheet.lay_down(end)
        if self._has_metadata:
            self._save_metadata()
        self._latest, self._size = time.monotonic(), 0

    def _save_metadata(self) -> None:
        text = metadata_text(self._path.name, self._topics, self.counts, self._span)
        draft = self._path.with_name(f".{METADATA}")
        draft.write_text(text, encoding="utf-8")
        draft.replace(self._path.with_name(METADATA))

    def close(self, lost: Mapping[str, int] | None = None) -> None:
        """Save and close; `lost` messages of each topic are told in the file."""
        if lost:
            self._writer.add_metadata(LOST, {name: str(count) for name, count in lost.items()})
        self.save()
        self._sheet.close()


FOREVER = "{sec: 9223372036, nsec: 854775807}"


def quality_text(topic: Topic) -> str:
    """Return the QoS of a topic's publisher as rosbag2 writes it."""
    return (
        f"- history: keep_last\n  depth: {topic.depth}\n"
        f"  reliability: {'reliable' if topic.is_reliable else 'best_effort'}\n"
        f"  durability: {'transient_local' if topic.is_latched else 'volatile'}\n"
        f"  deadline: {FOREVER}\n  lifespan: {FOREVER}\n  liveliness: automatic\n"
        f"  liveliness_lease_duration: {FOREVER}\n  avoid_ros_namespace_conventions: false\n"
    )


def metadata_text(
    name: str, topics: Mapping[str, Topic], counts: Mapping[str, int], span: tuple[int, int]
) -> str:
    """Return rosbag2's metadata (version 9, ROS 2 Jazzy) of a bag of one file.

    Args:
        span: [ns] times of the first and the last message.
    """
    start = {"nanoseconds_since_epoch": span[0]}
    duration = {"nanoseconds": span[1] - span[0]}
    total = sum(counts.values())
    rows = [
        {
            "topic_metadata": {
                "name": topic.name,
                "type": topic.type,
                "serialization_format": "cdr",
                "offered_qos_profiles": yaml.safe_load(quality_text(topic)),
                "type_description_hash": type_hash(topic.type),
            },
            "message_count": counts[topic.name],
        }
        for topic in topics.values()
        if counts[topic.name]
    ]
    file = {"path": name, "starting_time": start, "duration": duration, "message_count": total}
    content = {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": duration,
        "starting_time": start,
        "message_count": total,
        "topics_with_message_count": rows,
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [name],
        "files": [file],
        "custom_data": None,
        "ros_distro": "jazzy",
    }
    tree = {"rosbag2_bagfile_information": content}
    return str(yaml.dump(tree, Dumper=_Plain, sort_keys=False))


class _Plain(yaml.SafeDumper):
    """Writes a value that occurs twice twice, not as an alias."""

    def ignore_aliases(self, data: object) -> bool:
        return True

"""A recorded bag: its topics, its messages in order of time, and the last ones before a time."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from swarm_common.middleware.topic_table import Topic
from swarm_common.model.errors import ConfigError

NANOSECONDS = 1_000_000_000
LOOK_BACK = 20 * NANOSECONDS  # how far a message that does not stay is looked for
Item = tuple[str, int, bytes]  # topic, time [ns], serialized message


class Bag:
    """An MCAP file of ROS 2 messages.

    Attributes:
        path: Of the file.
        topics: By name; quality as far as the file says.
        counts: Messages by topic.
        start: [s] time of the first message, of those that stay for latecomers apart.
        end: [s] time of the last message.
        about: Facts about the run, if swarm-up wrote the file.
        was_cut: Whether the file had no end and was put in order in memory.
    """

    def __init__(self, path: Path) -> None:
        """Open a bag.

        Args:
            path: The file, or the folder of a recording or of a run.

        Raises:
            ConfigError: If it is no such file.
        """
        self.path = _find(path)
        self.was_cut = False
        self._stream: BinaryIO = self.path.open("rb")
        try:
            self._reader = self._open()
        except (McapError, ValueError, OSError) as cause:
            self.close()
            raise ConfigError(f"{self.path} is not a readable MCAP file: {cause}") from cause

    def _open(self) -> McapReader:
        reader = make_reader(self._stream)
        try:
            summary = reader.get_summary()
        except McapError:
            summary = None
        if summary is None or summary.statistics is None:
            self.close()
            self._stream, self.was_cut = mend(self.path), True
            reader = make_reader(self._stream)
            summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            raise McapError("it has no messages")
        counts = summary.statistics.channel_message_counts
        self.topics = {
            channel.topic: _topic(channel, summary.schemas.get(channel.schema_id))
            for channel in summary.channels.values()
            if counts.get(channel.id)
        }
        self.counts = {
            channel.topic: counts[channel.id]
            for channel in summary.channels.values()
            if counts.get(channel.id)
        }
        passing = [name for name, topic in self.topics.items() if not topic.is_latched]
        first = next(iter(reader.iter_messages(passing)), None) if passing else None
        earliest = summary.statistics.message_start_time
        self.start = (earliest if first is None else first[2].log_time) / NANOSECONDS
        self.end = summary.statistics.message_end_time / NANOSECONDS
        self.about: dict[str, str] = {}
        for record in reader.iter_metadata():
            if record.name == "swarm":
                self.about = dict(record.metadata)
        return reader

    def messages(
        self, topics: Collection[str] | None = None, after: int | None = None
    ) -> Iterator[Item]:
        """Yield messages in order of time.

        Args:
            topics: Only of these.
            after: [ns] only later ones.
        """
        wanted = None if topics is None else sorted(topics)
        if wanted == []:
            return
        for _, channel, message in self._reader.iter_messages(wanted, starting_after=after):
            yield channel.topic, message.log_time, message.data

    def latest(self, topics: Collection[str], at: int) -> list[Item]:
        """Return the last message of each topic up to a time [ns], as far as there is one.

        Topics that stay for latecomers are looked for from the start, others for a while back.
        """
        latched = {name for name in topics if name in self.topics and self.topics[name].is_latched}
        others = set(topics) & (self.topics.keys() - latched)
        found: dict[str, Item] = {}
        if latched:
            for _, channel, message in self._reader.iter_messages(sorted(latched), ending_at=at):
                found[channel.topic] = (channel.topic, message.log_time, message.data)
        back = self._reader.iter_messages(
            sorted(others), starting_at=max(0, at - LOOK_BACK), ending_at=at, reverse=True
        )
        for _, channel, message in back if others else ():
            found.setdefault(channel.topic, (channel.topic, message.log_time, message.data))
            if others <= found.keys():
                break
        return sorted(found.values(), key=lambda item: item[1])

    def close(self) -> None:
        """Close the file."""
        self._stream.close()


def mend(path: Path) -> BinaryIO:
    """Return a complete copy of the readable part of a file that ends in the middle."""
    copy = tempfile.TemporaryFile(prefix="swarm-bag-")
    writer = Writer(copy)
    writer.start(profile="ros2", library="swarm-workbench")
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, int] = {}
    with path.open("rb") as stream, contextlib.suppress(McapError, ValueError, EOFError):
        for record in StreamReader(stream).records:
            if isinstance(record, Schema) and record.id not in schemas:
                schemas[record.id] = writer.register_schema(
                    record.name, record.encoding, record.data
                )
            elif isinstance(record, Channel) and record.id not in channels:
                channels[record.id] = writer.register_channel(
                    record.topic,
                    record.message_encoding,
                    schemas[record.schema_id],
                    record.metadata,
                )
            elif isinstance(record, Metadata):
                writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Message):
                writer.add_message(
                    channels[record.channel_id],
                    record.log_time,
                    record.data,
                    record.publish_time,
                    record.sequence,
                )
    writer.finish()  # type: ignore[no-untyped-call]
    copy.flush()
    copy.seek(0)
    return copy


def _find(path: Path) -> Path:
    """Return the MCAP file that a path names."""
    if path.is_file():
        return path
    found = sorted(path.glob("*.mcap")) or sorted((path / "recording").glob("*.mcap"))
    if not found:
        raise ConfigError(
            f"{path}: there is no bag; expected an .mcap file, or the folder of a run that was"
            " made with --record"
        )
    return found[0]


def _topic(channel: Channel, schema: Schema | None) -> Topic:
    quality = channel.metadata.get("offered_qos_profiles", "")
    return Topic(
        channel.topic,
        schema.name if schema is not None else "",
        is_reliable="reliability: best_effort" not in quality,
        is_latched="durability: transient_local" in quality,
    )

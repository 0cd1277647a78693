"""A recorded bag: its topics, its messages in order of time, and the last ones before a time."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
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
        was_cut: Whether the file had no end, or is damaged, and was put in order beside it.
    """

    def __init__(self, path: Path, tell: Callable[[str], None] = lambda words: None) -> None:
        """Open a bag.

        A file that has no end, or a damaged part, is read as far as it can be, whenever that is
        noticed: the parts that are whole are copied to a temporary file.

        Args:
            path: The file, or the folder of a recording or of a run.
            tell: Told that the file is no longer whole.

        Raises:
            ConfigError: If it is no such file, or nothing in it can be read.
        """
        self.path = _find(path)
        self.was_cut = False
        self._tell = tell
        self._stream: BinaryIO = self.path.open("rb")
        try:
            self._reader = self._indexed()
        except Exception:  # libraries raise anything over damaged bytes
            self._put_in_order()

    def _put_in_order(self) -> None:
        """Read a copy of the parts that are whole from now on.

        Raises:
            ConfigError: If there are none, or this is the copy.
        """
        self.close()
        try:
            if self.was_cut:
                raise McapError("its copy cannot be read, either")
            self._stream, self.was_cut = mend(self.path), True
            self._reader = self._indexed()
        except Exception as cause:  # likewise
            self.close()
            raise ConfigError(f"{self.path} is not a readable MCAP file: {cause}") from cause
        self._tell(f"{self.path} has no end, or is damaged: what can be read of it is shown")

    def _indexed(self) -> McapReader:
        """Return a reader, once what the file says of all its messages is known."""
        reader = make_reader(self._stream, validate_crcs=True)
        summary = reader.get_summary()
        if summary is None or summary.statistics is None or not summary.channels:
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
            after: [ns] only later ones.

        Raises:
            ConfigError: If nothing more can be read.
        """
        wanted = None if topics is None else sorted(topics)
        if wanted == []:
            return
        is_at_end = False
        while not is_at_end:
            try:
                for _, channel, message in self._reader.iter_messages(wanted, starting_after=after):
                    yield channel.topic, message.log_time, message.data
                    after = message.log_time
                is_at_end = True
            except Exception:  # a damaged part
                self._put_in_order()

    def latest(self, topics: Collection[str], at: int) -> list[Item]:
        """Return the last message of each topic up to a time [ns], as far as there is one.

        Topics that stay for latecomers are looked for from the start, others for a while back.

        Raises:
            ConfigError: If nothing more can be read.
        """
        try:
            return self._latest(topics, at)
        except Exception:  # a damaged part
            self._put_in_order()
            return self._latest(topics, at)

    def _latest(self, topics: Collection[str], at: int) -> list[Item]:
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
    """Return a complete copy of what is readable in a file that has no end, or damaged parts."""
    copy = tempfile.TemporaryFile(prefix="swarm-bag-")
    writer = Writer(copy)
    writer.start(profile="ros2", library="swarm-workbench")
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, int] = {}
    for record in _readable(path):
        if isinstance(record, Schema) and record.id not in schemas:
            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel) and record.schema_id in schemas:
            if record.id not in channels:
                channels[record.id] = writer.register_channel(
                    record.topic,
                    record.message_encoding,
                    schemas[record.schema_id],
                    record.metadata,
                )
        elif isinstance(record, Metadata):
            writer.add_metadata(record.name, record.metadata)
        elif isinstance(record, Message) and record.channel_id in channels:
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


def _readable(path: Path) -> Iterator[McapRecord]:
    """Yield the records of a file but for those in damaged chunks, up to other damage."""
    with path.open("rb") as stream:
        with contextlib.suppress(Exception):  # it has no summary
            summary = make_reader(stream).get_summary()
            if summary is not None:
                yield from summary.schemas.values()
                yield from summary.channels.values()
        stream.seek(0)
        with contextlib.suppress(Exception):  # libraries raise anything over damaged bytes
            for record in StreamReader(stream, emit_chunks=True).records:
                if not isinstance(record, Chunk):
                    yield record
                    continue
                with contextlib.suppress(Exception):
                    yield from breakup_chunk(record, validate_crc=True)


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

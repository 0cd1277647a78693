"""One MCAP file of a bag: whole, compressed, without an index, cut off or damaged."""

from __future__ import annotations

import contextlib
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NamedTuple

import zstandard
from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC, Writer

from swarm_common.model.errors import ConfigError
from swarm_recording.bag_folder import wrong_format
from swarm_recording.bag_metadata import Offer, offers
from swarm_recording.tape import LOST

NANOSECONDS = 1_000_000_000
CDR = "cdr"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"  # no CDR message begins like this
OTHER_MAGIC = (b"SQLite format 3\0", b"#ROSBAG V")
LARGEST_WINDOW = 2**31  # [bytes] that `zstd --ultra --long=31` may refer back
SHORT_TYPE = re.compile(r"(\w+)/(\w+)")


class Item(NamedTuple):
    """A recorded message."""

    topic: str
    time: int  # [ns]
    data: bytes  # serialized


class MessageKind(NamedTuple):
    """Type and encoding of the messages of a channel."""

    type: str  # like ``nav_msgs/msg/Path``; empty if the file does not say
    encoding: str  # of the messages; ROS 2 has ``cdr``


@dataclass(frozen=True, slots=True)
class Stream:
    """The messages of one channel of a file."""

    topic: str
    kind: MessageKind
    offered: tuple[Offer, ...]
    count: int
    definition: str = ""  # of the type, as of ROS 2's .msg files; empty if it is in another form
    fault: str = ""  # what was not understood of its quality


class McapFile:
    """A file whose messages are read in order of time.

    Attributes:
        path: Path of the file.
        streams: Streams of its messages; empty if it has none.
        about: Facts about the run, if swarm-up wrote the file.
        lost: Messages that were sent and are not there, by topic, if the file says so.
        chunks: [ns] times of the first and the last message of each of its parts.
        span: [ns] times of the first and the last message.
        was_cut: Whether it has no end, or is damaged, and its readable parts are read.
    """

    def __init__(self, path: Path, tell: Callable[[str], None], *, stays_open: bool) -> None:
        """Open a file.

        Args:
            tell: Told once if it is no longer whole.
            stays_open: Whether it is open also while nobody reads it.

        Raises:
            ConfigError: If nothing in it can be read.
        """
        self.path, self._tell, self._stays_open = path, tell, stays_open
        self.was_cut = False
        self._users = 0  # iterators in use
        self._stream: BinaryIO | None = None
        self._reader: McapReader | None = None
        self._is_copied = False
        with self._use():
            self._open()

    def _open(self) -> McapReader:
        """Return a reader of the file, or of a copy in order."""
        if self._reader is not None:
            return self._reader
        stream = _unpacked(self.path)
        try:
            if self._is_copied:
                raise McapError("it is to be copied again")
            return self._read_from(stream)
        except Exception:  # libraries raise anything over damaged bytes
            return self._read_from_copy(stream)

    def _read_from_copy(self, stream: BinaryIO) -> McapReader:
        """Return a reader of a copy of the readable parts, used from now on.

        Raises:
            ConfigError: If there are none.
        """
        try:
            with stream:
                copy, is_whole = mended(stream)
            reader = self._read_from(copy)
        except Exception as cause:  # likewise
            self.close()
            raise ConfigError(f"{self.path} is not a readable MCAP file: {cause}") from cause
        self._is_copied = True
        if not is_whole and not self.was_cut:
            self.was_cut = True
            count, end = sum(s.count for s in self.streams), self.span[1] / NANOSECONDS
            self._tell(
                f"{self.path} has no end, or is damaged: what can be read of it is shown,"
                f" {count} messages up to {end:.3f} s"
            )
        return reader

    def _read_from(self, stream: BinaryIO) -> McapReader:
        """Return a reader of a stream, used from now on, once what it has is known."""
        self._stream = stream
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        statistics = None if summary is None else summary.statistics
        if summary is None or statistics is None:
            raise McapError("it has no messages")
        if statistics.message_count and not summary.chunk_indexes:
            raise McapError("it has no index")
        self.streams = tuple(_streams(summary, statistics.channel_message_counts))
        self.chunks = [
            (chunk.message_start_time, chunk.message_end_time) for chunk in summary.chunk_indexes
        ]
        self.span = (statistics.message_start_time, statistics.message_end_time)
        self.about: dict[str, str] = {}
        self.lost: dict[str, int] = {}
        for record in reader.iter_metadata():
            if record.name == "swarm":
                self.about = dict(record.metadata)
            elif record.name == LOST:
                counts = record.metadata.items()
                self.lost = {name: int(n) for name, n in counts if re.fullmatch(r"\d{1,15}", n)}
        self._reader = reader
        return reader

    def _reopen_as_copy(self, damaged: McapReader) -> None:
        """After a damaged part: read a copy of what is whole, if nobody has begun to.

        Raises:
            ConfigError: If this is the copy.
        """
        if self._reader is not damaged:
            return
        self.close()
        if self._is_copied:
            raise ConfigError(f"{self.path} is not a readable MCAP file")
        self._is_copied = True

    @contextlib.contextmanager
    def _use(self) -> Iterator[None]:
        """Keep the file open for as long as this lasts."""
        self._users += 1
        try:
            yield
        finally:
            self._users -= 1
            if not (self._users or self._stays_open):
                self.close()

    def messages(
        self, kinds: Mapping[str, MessageKind], after: int | None = None, until: int | None = None
    ) -> Iterator[Item]:
        """Yield messages in order of time, of topics and their kinds.

        Args:
            after: [ns] only later ones.
            until: [ns] no later ones.

        Raises:
            ConfigError: If nothing more can be read.
        """
        at, done = 0 if after is None else after + 1, 0  # `done` messages of time `at` are out
        with self._use():
            while True:
                reader, skipped = self._open(), done
                try:
                    for item in _items(reader, kinds, at, until):
                        if skipped and item.time == at:
                            skipped -= 1
                            continue
                        if item.time > at:
                            at, done = item.time, 0
                        done += 1
                        yield item
                    return
                except Exception:  # a damaged part
                    self._reopen_as_copy(reader)

    def newest(self, kinds: Mapping[str, MessageKind], first: int, until: int) -> dict[str, Item]:
        """Return the last message of each topic between two times [ns], both included.

        Raises:
            ConfigError: If nothing more can be read.
        """
        with self._use():
            reader = self._open()
            try:
                found: dict[str, Item] = {}
                for item in _items(reader, kinds, first, until, backwards=True):
                    found.setdefault(item.topic, item)
                    if len(found) == len(kinds):
                        break
                return found
            except Exception:  # a damaged part
                self._reopen_as_copy(reader)
                return self.newest(kinds, first, until)

    def close(self) -> None:
        """Close the file; the next reading opens it again."""
        if self._stream is not None:
            self._stream.close()
        self._stream = self._reader = None


def _items(
    reader: McapReader,
    kinds: Mapping[str, MessageKind],
    first: int,
    until: int | None,
    *,
    backwards: bool = False,
) -> Iterator[Item]:
    """Yield the messages of a reader between two times [ns], both included."""
    if not kinds or (until is not None and until < first):
        return
    fitting: dict[int, bool] = {}
    for schema, channel, message in reader.iter_messages(
        kinds, starting_at=first, ending_at=until, reverse=backwards
    ):
        if channel.id not in fitting:
            fitting[channel.id] = _kind(channel, schema) == kinds[channel.topic]
        if fitting[channel.id]:
            is_packed = channel.message_encoding == CDR and message.data.startswith(ZSTD_MAGIC)
            data = message.data
            if is_packed:  # by rosbag2, message by message
                unpacker = zstandard.ZstdDecompressor(max_window_size=LARGEST_WINDOW)
                data = unpacker.decompressobj().decompress(data)
            yield Item(channel.topic, message.log_time, data)


def mended(stream: BinaryIO) -> tuple[BinaryIO, bool]:
    """Return an indexed copy of what is readable in a file, and whether that was all of it."""
    faults: list[Exception] = []
    copy = tempfile.TemporaryFile(prefix="swarm-bag-")
    try:
        _copy_readable(stream, copy, faults)
    except BaseException:
        copy.close()
        raise
    copy.seek(0)
    return copy, not faults


def _copy_readable(stream: BinaryIO, copy: BinaryIO, faults: list[Exception]) -> None:
    """Write what is readable in a file to another, with an index; note what was not."""
    writer = Writer(copy)
    writer.start(profile="ros2", library="swarm-workbench")
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, int] = {}
    for record in _readable(stream, faults):
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
    if faults and not channels:
        raise faults[-1]
    writer.finish()  # type: ignore[no-untyped-call]
    copy.flush()


def _readable(stream: BinaryIO, faults: list[Exception]) -> Iterator[McapRecord]:
    """Yield the records of a file but for those in damaged chunks, up to other damage."""
    with contextlib.suppress(Exception):  # it has no summary
        summary = make_reader(stream).get_summary()
        if summary is not None:
            yield from summary.schemas.values()
            yield from summary.channels.values()
    stream.seek(0)
    try:
        for record in StreamReader(stream, emit_chunks=True).records:
            if not isinstance(record, Chunk):
                yield record
                continue
            try:
                yield from breakup_chunk(record, validate_crc=True)
            except Exception as fault:  # libraries raise anything over damaged bytes
                faults.append(fault)
    except Exception as fault:  # likewise
        faults.append(fault)


def _unpacked(path: Path) -> BinaryIO:
    """Return the content of a file; of one that rosbag2 compressed as a whole, a copy.

    Raises:
        ConfigError: If it is something else, or cannot be unpacked.
    """
    stream = path.open("rb")
    magic = stream.read(len(max(OTHER_MAGIC, key=len)))
    stream.seek(0)
    if magic.startswith(OTHER_MAGIC):
        stream.close()
        raise wrong_format(path, path)
    if not magic.startswith(ZSTD_MAGIC):
        return stream
    copy = tempfile.TemporaryFile(prefix="swarm-bag-")
    unpacker = zstandard.ZstdDecompressor(max_window_size=LARGEST_WINDOW)
    with stream, contextlib.suppress(zstandard.ZstdError):  # a cut file is read up to the cut
        shutil.copyfileobj(unpacker.stream_reader(stream, read_across_frames=True), copy)
    copy.seek(0)
    start = copy.read(len(MCAP0_MAGIC))
    copy.seek(0)
    if start != MCAP0_MAGIC:
        copy.close()
        if start and OTHER_MAGIC[0].startswith(start):
            raise wrong_format(path, path)
        what = "something else than MCAP" if start else "nothing that can be unpacked"
        raise ConfigError(f"{path} is compressed by zstd, with {what} in it")
    return copy


def _streams(summary: Summary, counts: Mapping[int, int]) -> Iterator[Stream]:
    for number, count in counts.items():
        if not count:
            continue
        channel = summary.channels[number]
        schema = summary.schemas[channel.schema_id] if channel.schema_id else None
        is_msg = schema is not None and schema.encoding == "ros2msg"
        text = schema.data.decode(errors="replace") if schema is not None and is_msg else ""
        try:
            offered, fault = offers(channel.metadata.get("offered_qos_profiles", "")), ""
        except ConfigError as error:
            offered, fault = [], str(error)
        yield Stream(channel.topic, _kind(channel, schema), tuple(offered), count, text, fault)


def _kind(channel: Channel, schema: Schema | None) -> MessageKind:
    name = "" if schema is None else schema.name
    short = SHORT_TYPE.fullmatch(name)
    return MessageKind(f"{short[1]}/msg/{short[2]}" if short else name, channel.message_encoding)

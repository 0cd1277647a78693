"""A recorded bag: its topics, its messages in order of time, and the last ones before a time."""

from __future__ import annotations

import heapq
from collections import defaultdict, deque
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path

from swarm_common.middleware.topic_table import Topic
from swarm_common.model.errors import ConfigError
from swarm_recording.bag_folder import bag_files
from swarm_recording.bag_metadata import METADATA, BagMetadata, Offer, offers, united
from swarm_recording.mcap_file import CDR, NANOSECONDS, Item, McapFile, MessageKind, Stream

__all__ = ["NANOSECONDS", "Bag", "Item"]
LOOK_BACK = 20 * NANOSECONDS  # how far a message that does not stay is looked for
SHOWN = 5  # names in a message


class Bag:
    """One or several MCAP files of ROS 2 messages.

    Attributes:
        path: Path of its only file, or of the folder.
        files: In the order of metadata.yaml.
        topics: By name; quality as far as the files say.
        encodings: Encodings of the messages, by topic: ``cdr`` in ROS 2.
        definitions: Definitions of the types, by topic; empty where they are not in the form of
            .msg files.
        counts: Messages by topic.
        first: [ns] time of the first message, of those that stay for latecomers apart.
        last: [ns] time of the last message.
        about: Facts about the run, if swarm-up wrote the file.
        lost: Messages that were sent and are not there, by topic, if the files say so.
    """

    def __init__(self, path: Path, tell: Callable[[str], None] = lambda words: None) -> None:
        """Open a bag.

        A file that has no end, or a damaged part, is read as far as it can be, whenever that is
        noticed: the parts that are whole are copied to a temporary file.

        Args:
            path: A file, or the folder of a recording or of a run.
            tell: Told of everything that the bag lacks, and that is not read.

        Raises:
            ConfigError: If there is no bag, or nothing in it can be read.
        """
        self._tell = tell
        paths, metadata = bag_files(path, tell)
        self._files = self._opened(paths)
        self.files = tuple(file.path for file in self._files)
        self.path = self.files[0] if len(self.files) == 1 else self.files[0].parent
        self.about = next((file.about for file in self._files if file.about), {})
        lost = [item for file in self._files for item in file.lost.items()]
        self.lost = {name: sum(n for topic, n in lost if topic == name) for name, _ in lost}
        self.topics: dict[str, Topic] = {}
        self.encodings: dict[str, str] = {}
        self.definitions: dict[str, str] = {}
        self.counts: dict[str, int] = {}
        self._kinds: dict[str, MessageKind] = {}
        self._know(metadata)
        spans = [file.span for file in self._files if file.streams]
        self.last = max(span[1] for span in spans)
        passing = [name for name, topic in self.topics.items() if not topic.is_latched]
        try:
            first = next(self.messages(passing), None)
        except ConfigError:
            self.close()
            raise
        self.first = min(span[0] for span in spans) if first is None else first.time

    @property
    def start(self) -> float:
        """[s] time of `first`."""
        return self.first / NANOSECONDS

    @property
    def end(self) -> float:
        """[s] time of `last`."""
        return self.last / NANOSECONDS

    @property
    def was_cut(self) -> bool:
        """Whether a file had no end, or is damaged."""
        return any(file.was_cut for file in self._files)

    def _opened(self, paths: Collection[Path]) -> list[McapFile]:
        """Return the files that can be read; one of several that cannot is told.

        Raises:
            ConfigError: If none can.
        """
        files: list[McapFile] = []
        faults: list[ConfigError] = []
        for path in paths:
            try:
                files.append(McapFile(path, self._tell, stays_open=len(paths) == 1))
            except ConfigError as error:
                faults.append(error)
        if not files:
            raise faults[0]
        for fault in faults:
            self._tell(f"{fault}; the other files are read")
        if not any(file.streams for file in files):
            files[0].close()
            raise ConfigError(f"{files[0].path}: the bag has no messages")
        return files

    def _know(self, metadata: BagMetadata) -> None:
        """Learn what the topics are, from all files and the metadata."""
        streams: dict[str, list[Stream]] = defaultdict(list)
        for file in self._files:
            for stream in file.streams:
                streams[stream.topic].append(stream)
        for name, found in streams.items():
            kind = self._kinds[name] = found[0].kind
            fitting = [stream for stream in found if stream.kind == kind]
            others = [stream for stream in found if stream.kind != kind]
            for other in {stream.kind for stream in others}:
                count = sum(stream.count for stream in others if stream.kind == other)
                self._tell(
                    f"{self.path}: {name} is of {_named(kind)} and of {_named(other)}:"
                    f" {count} messages of the latter are not read"
                )
            self.encodings[name] = kind.encoding
            self.definitions[name] = fitting[0].definition
            self.counts[name] = sum(stream.count for stream in fitting)
            offered = self._offers(name, fitting, metadata.qualities.get(name, ""))
            is_reliable, is_latched, depth = united(offered)
            self.topics[name] = Topic(name, kind.type, is_reliable, is_latched, depth=depth)
        self._compare(metadata)

    def _offers(self, name: str, streams: Collection[Stream], otherwise: object) -> list[Offer]:
        """Return the offers of a topic's publishers, each once for all files."""
        faults = {stream.fault for stream in streams if stream.fault}
        found = list(dict.fromkeys(stream.offered for stream in streams if stream.offered))
        try:
            rows = [offer for row in found for offer in row] or offers(otherwise)
        except ConfigError as error:
            faults, rows = faults | {str(error)}, []
        for words in faults:
            self._tell(f"{self.path}: {name}: {words}; it is played as reliable")
        return rows

    def _compare(self, metadata: BagMetadata) -> None:
        """Tell where the files have other messages than the metadata says."""
        total = sum(stream.count for file in self._files for stream in file.streams)
        differing = [
            f"{name}: {self.counts.get(name, 0)} of {count}"
            for name, count in metadata.counts.items()
            if self.counts.get(name, 0) != count
        ]
        if metadata.message_count not in (None, total) or differing:
            more = f" and {len(differing) - SHOWN} more" if len(differing) > SHOWN else ""
            rows = f" ({', '.join(differing[:SHOWN])}{more})" if differing else ""
            self._tell(
                f"{self.path}: the files have {total} messages, {METADATA} says"
                f" {metadata.message_count}{rows}"
            )

    def gaps(self, least: float) -> list[tuple[float, float]]:
        """Return where for at least so long [s] there is no message: from when to when [s].

        Raises:
            ConfigError: If nothing more can be read.
        """
        limit = round(least * NANOSECONDS)
        times: list[tuple[int, int]] = []
        for begin, end in [chunk for file in self._files for chunk in file.chunks]:
            if end - begin < limit:
                times.append((begin, end))
                continue
            for item in self.messages(after=begin - 1):
                if item.time > end:
                    break
                times.append((item.time, item.time))
        found, until = [], self.first
        for begin, end in sorted(times):
            if begin - until >= limit:
                found.append((until / NANOSECONDS, begin / NANOSECONDS))
            until = max(until, end)
        return found

    def messages(
        self, topics: Collection[str] | None = None, after: int | None = None
    ) -> Iterator[Item]:
        """Yield messages in order of time; those of one time in the order of the files.

        Args:
            after: [ns] only later ones.

        Raises:
            ConfigError: If nothing more can be read.
        """
        return self._merged(self._kinds_of(topics), after)

    def latest(self, topics: Collection[str], at: int) -> list[Item]:
        """Return the last message of each topic up to a time [ns], as far as there is one.

        Topics that stay for latecomers are looked for from the start, and as many of their messages
        are returned as latecomers get. Others are looked for a while back.

        Raises:
            ConfigError: If nothing more can be read.
        """
        kinds = self._kinds_of(topics)
        latched = {name: kind for name, kind in kinds.items() if self.topics[name].is_latched}
        others = {name: kind for name, kind in kinds.items() if name not in latched}
        kept = {name: deque[Item](maxlen=self.topics[name].depth) for name in latched}
        for item in self._merged(latched, None, at):
            kept[item.topic].append(item)
        found: dict[str, Item] = {}
        back = max(0, at - LOOK_BACK)
        for file in self._files if others else ():
            if file.streams and file.span[0] <= at and file.span[1] >= back:
                for name, item in file.newest(others, back, at).items():
                    if name not in found or item.time >= found[name].time:
                        found[name] = item
        items = [item for row in kept.values() for item in row]
        return sorted([*items, *found.values()], key=lambda item: item.time)

    def _kinds_of(self, topics: Collection[str] | None) -> dict[str, MessageKind]:
        names = self._kinds if topics is None else self._kinds.keys() & set(topics)
        return {name: self._kinds[name] for name in sorted(names)}

    def _merged(
        self, kinds: Mapping[str, MessageKind], after: int | None, until: int | None = None
    ) -> Iterator[Item]:
        """Merge the files; each is open from its first message to its last one only."""
        waiting = deque(
            sorted(
                (file.span[0], number, file)
                for number, file in enumerate(self._files)
                if any(stream.topic in kinds for stream in file.streams)
                and (after is None or file.span[1] > after)
                and (until is None or file.span[0] <= until)
            )
        )
        if len(waiting) == 1:
            yield from waiting[0][2].messages(kinds, after, until)
            return
        heap: list[tuple[int, int, Item, Iterator[Item]]] = []
        while waiting or heap:
            if waiting and (not heap or waiting[0][0] <= heap[0][0]):
                _, number, file = waiting.popleft()
                stream = file.messages(kinds, after, until)
            else:
                _, number, item, stream = heapq.heappop(heap)
                yield item
            following = next(stream, None)
            if following is not None:
                heapq.heappush(heap, (following.time, number, following, stream))

    def close(self) -> None:
        """Close the files."""
        for file in self._files:
            file.close()


def _named(kind: MessageKind) -> str:
    encoding = "" if kind.encoding == CDR else f" ({kind.encoding})"
    return (kind.type or "no type") + encoding

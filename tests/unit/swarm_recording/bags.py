"""Writes bags as rosbag2 and others do."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import yaml
from mcap.writer import CompressionType, Writer

NOTE, OTHER = "/note", "/other"
STRING = "std_msgs/msg/String"
Message = tuple[str, int, bytes]  # topic, time [ns], data


def cdr(text: str) -> bytes:
    data = (len(text) + 1).to_bytes(4, "little") + text.encode() + b"\0"
    return b"\0\1\0\0" + data + bytes(-len(data) % 4)  # as DDS fills it up


def notes(count: int, topics: Sequence[str] = (NOTE,)) -> list[Message]:
    return [
        (topics[k % len(topics)], 10**9 * 100 + k * 10**8, cdr(f"note {k}")) for k in range(count)
    ]


def write(
    path: Path,
    messages: Iterable[Message],
    *,
    kind: str = STRING,
    definition: str = "string data",
    quality: str = "",
    encoding: str = "cdr",
    end: bool = True,
    **settings: object,
) -> Path:
    """Write a file with one channel for each topic."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        writer = Writer(file, **{"compression": CompressionType.ZSTD, **settings})
        writer.start(profile="ros2", library="test")
        schema = writer.register_schema(kind, "ros2msg", definition.encode())
        channels: dict[str, int] = {}
        for topic, time, data in messages:
            if topic not in channels:
                channels[topic] = writer.register_channel(
                    topic, encoding, schema, {"offered_qos_profiles": quality}
                )
            writer.add_message(channels[topic], time, data, time)
        if end:
            writer.finish()
        else:
            writer.flush()
    return path


def metadata(names: Sequence[str], messages: Sequence[Message]) -> dict[str, object]:
    """Return rosbag2's metadata of version 9."""
    start = min((time for _, time, _ in messages), default=0)
    span = max((time for _, time, _ in messages), default=0) - start
    topics = sorted({topic for topic, _, _ in messages})
    return {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": span},
        "starting_time": {"nanoseconds_since_epoch": start},
        "message_count": len(messages),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic,
                    "type": STRING,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [],
                    "type_description_hash": "RIHS01_0",
                },
                "message_count": sum(name == topic for name, _, _ in messages),
            }
            for topic in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": list(names),
        "files": [
            {
                "path": name,
                "starting_time": {"nanoseconds_since_epoch": start + index},
                "duration": {"nanoseconds": 7 + index},
                "message_count": 70 + index,
            }
            for index, name in enumerate(names)
        ],
        "custom_data": {"driver": "somebody"},
        "ros_distro": "jazzy",
    }


def write_metadata(folder: Path, content: dict[str, object]) -> None:
    text = yaml.safe_dump({"rosbag2_bagfile_information": content}, sort_keys=False)
    (folder / "metadata.yaml").write_text(text)


def split_bag(folder: Path, parts: Sequence[Sequence[Message]], **settings: object) -> Path:
    names = [f"part_{index}.mcap" for index in range(len(parts))]
    for name, part in zip(names, parts, strict=True):
        write(folder / name, part, **settings)
    write_metadata(folder, metadata(names, [message for part in parts for message in part]))
    return folder

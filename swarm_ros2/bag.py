"""`ros2 bag`: info, play, record."""

from __future__ import annotations

import argparse
import math
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from swarm_common.model.errors import SwarmError
from swarm_common.model.run_words import lost_text
from swarm_recording.bag import NANOSECONDS, Bag
from swarm_ros2 import launcher
from swarm_ros2.verbs import add_flag, add_verb

FILE = "recording.mcap"
CLOCK_RATE = 40.0  # [Hz] of wall time, as of rosbag2
# Options of rosbag2 in Jazzy that are not here, short and long names.
NOT_OF_PLAY = (
    "-i --input", "--services", "-e --regex", "-x --exclude-regex", "--exclude-topics",
    "--exclude-services", "--qos-profile-overrides-path", "-m --remap", "--storage-config-file",
    "--clock-topics", "--clock-topics-all", "-d --delay", "--playback-duration",
    "--playback-until-sec", "--playback-until-nsec", "-p --start-paused", "--wait-for-all-acked",
    "--publish-service-requests", "--service-requests-source", "--log-level",
)  # fmt: skip
NOT_OF_RECORD = (
    "--topic-types", "--exclude-topic-types", "--services", "--all-services", "-e --regex",
    "--exclude-regex", "-x --exclude", "--exclude-topics", "--exclude-services",
    "--include-unpublished-topics", "--ignore-leaf-topics", "--no-discovery",
    "-p --polling-interval", "--publisher-options", "--qos-profile-overrides-path",
    "-f --serialization-format", "--storage-config-file", "--storage-preset-profile",
    "-b --max-bag-size", "-d --max-bag-duration", "--max-cache-size", "--start-paused",
    "--snapshot-mode", "--node-name", "--custom-data", "--log-level",
    "--compression-queue-size", "--compression-threads", "--compression-threads-priority",
    "--compression-mode", "--compression-format",
)  # fmt: skip
NO_SUCH = "this small ros2 does not have it"
TITLE = 19  # letters of the column with the titles
UNITS = ("B", "KiB", "MiB", "GiB")


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 bag`."""
    verb = add_verb(verbs, "info", "Print information about a bag to the screen", _info)
    verb.add_argument("bag_path", type=Path, help="Bag to open")
    add_flag(verb, "-t", "--topic-name", help="Only the topics' names")
    _add_storage(verb, "-v", "--verbose", "--sort")
    verb = add_verb(verbs, "play", "Play back ROS data from a bag", _play)
    verb.add_argument("bag_path", help="Bag to open")
    verb.add_argument("-r", "--rate", type=_positive, default=1.0, help="Rate of play back")
    verb.add_argument("--topics", nargs="+", default=[], metavar="TOPIC", help="Only these")
    add_flag(verb, "-l", "--loop", help="Play in a loop")
    late = "Begin this late, in seconds"
    verb.add_argument("--start-offset", type=_seconds, default=0.0, help=late)
    verb.add_argument(
        "--clock",
        type=_positive,
        nargs="?",
        const=CLOCK_RATE,
        metavar="HZ",
        help=f"Publish the bag's time on /clock, {CLOCK_RATE:g} times a second",
    )
    for name in ("--disable-keyboard-controls", "--disable-loan-message"):
        add_flag(verb, name, help="No effect: there are none")
    verb.add_argument("--read-ahead-queue-size", type=int, metavar="N", help="No effect")
    _add_storage(verb, *NOT_OF_PLAY)
    verb = add_verb(verbs, "record", "Record ROS data to a bag", _record)
    verb.add_argument("words", nargs="*", metavar="topics", help="Topics to be recorded")
    verb.add_argument("--topics", nargs="+", default=[], metavar="TOPIC", help="The same")
    add_flag(verb, "-a", "--all", "--all-topics", help="Record all topics")
    add_flag(verb, "--include-hidden-topics", help="Also with -a: hidden topics")
    verb.add_argument("-o", "--output", default="", help="Folder of the bag")
    add_flag(verb, "--disable-keyboard-controls", help="No effect: there are none")
    add_flag(verb, "--use-sim-time", help="Times of /clock, also if it comes later")
    _add_storage(verb, *NOT_OF_RECORD)


class _NotHere(argparse.Action):
    """An option of rosbag2 that ends in an error, whatever its values."""

    def __init__(self, option_strings: Sequence[str], dest: str, **settings: Any) -> None:
        super().__init__(option_strings, dest, nargs="*", help=argparse.SUPPRESS)

    def __call__(self, *arguments: Any) -> None:
        raise argparse.ArgumentError(
            None, f"{arguments[-1]} is an option of ROS 2's own 'ros2 bag'; {NO_SUCH}"
        )


def _add_storage(verb: argparse.ArgumentParser, *missing: str) -> None:
    """Add the storage, of which there is one, and the options that end in an error."""
    verb.add_argument("-s", "--storage", choices=["mcap"], help="Kind of bag")
    for names in missing:
        words = names.split()
        verb.add_argument(*words, action=_NotHere, dest=f"missing{words[-1]}")


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"it is {text}; expected a positive number")
    return value


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"it is {text}; expected seconds, 0 or more")
    return value


def _info(options: argparse.Namespace) -> None:
    bag = Bag(options.bag_path, _warn)
    if options.topic_name:
        print("\n".join(sorted(bag.topics)))
        return
    rows = [
        f"Topic: {name} | Type: {topic.type} | Count: {bag.counts[name]} |"
        f" Serialization Format: {bag.encodings[name]}"
        for name, topic in sorted(bag.topics.items())
    ]
    below = "\n" + " " * TITLE
    for title, value in {
        "Files": below.join(path.name for path in bag.files),
        "Bag size": _size(sum(path.stat().st_size for path in bag.files)),
        "Storage id": "mcap",
        "Duration": f"{(bag.last - bag.first) // NANOSECONDS}"
        f".{(bag.last - bag.first) % NANOSECONDS:09d}s",
        "Start": _moment(bag.first),
        "End": _moment(bag.last),
        "Messages": str(sum(bag.counts.values())),
        "Topic information": below.join(rows),
    }.items():
        print(f"{title + ':':<{TITLE}}{value}")
    bag.close()


def _warn(words: str) -> None:
    print(f"WARNING: {words}", file=sys.stderr)


def _size(count: float) -> str:
    for unit in UNITS[:-1]:
        if count < 1024:
            return f"{count:.0f} B" if unit == "B" else f"{count:.1f} {unit}"
        count /= 1024
    return f"{count:.1f} {UNITS[-1]}"


def _moment(nanoseconds: int) -> str:
    whole, rest = divmod(nanoseconds, NANOSECONDS)
    day = time.strftime("%b %e %Y %H:%M:%S", time.localtime(whole))
    return f"{day}.{rest:09d} ({whole}.{rest:09d})"


def _play(options: argparse.Namespace) -> None:
    words = [options.bag_path, "--ros", "--speed", str(options.rate)]
    if options.start_offset:
        words += ["--offset", repr(options.start_offset)]
    if options.topics:
        words += ["--topics", ",".join(f"/{name.lstrip('/')}" for name in options.topics)]
    if options.clock is not None:
        words += ["--clock", str(options.clock)]
    launcher.start("swarm_replay", [*words, *(["--loop"] if options.loop else [])])


def _record(options: argparse.Namespace) -> None:
    # rclpy is slow to import
    from swarm_recording.filter import RateFilter, WallStamps
    from swarm_recording.recorder import Recorder, run
    from swarm_recording.tape import Tape
    from swarm_recording.topic_source import GraphTopics
    from swarm_ros2 import graph

    words = [*options.words, *options.topics]
    if not (words or options.all):
        raise SwarmError("nothing to record: give names of topics, or --all")
    folder = Path(options.output or time.strftime("rosbag2_%Y_%m_%d-%H_%M_%S"))
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise SwarmError(f"{folder} is there already, and is not an empty folder")
    stopping: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _: stopping.append(number))
    with graph.open_node() as node:
        graph.settle(node)
        source = GraphTopics(
            node, ["*"] if options.all else words, _warn, hidden=options.include_hidden_topics
        )
        folder.mkdir(parents=True, exist_ok=True)
        tape = Tape(folder / FILE, {})
        stamps = RateFilter(None) if options.use_sim_time or source.has_clock() else WallStamps()
        recorder = Recorder(node, source, tape, stamps)
        who = f"{len(source.robots)} robots" if source.robots else f"{len(tape.counts)} topics"
        print(f"recording {who} to {folder}; Ctrl-C ends it", file=sys.stderr, flush=True)
        for word in source.missing():
            _warn(f"nobody publishes {word} so far; it is recorded as soon as somebody does")
        lost = run(recorder, tape, lambda: bool(stopping))
    if lost:
        _warn(lost_text(lost))
    print(f"{sum(tape.counts.values())} messages recorded", file=sys.stderr)

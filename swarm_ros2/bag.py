"""`ros2 bag`: info, play, record."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from swarm_recording.bag import Bag
from swarm_ros2 import launcher
from swarm_ros2.verbs import add_flag, add_verb

NANOSECONDS = 1_000_000_000
TITLE = 19  # letters of the column with the titles
UNITS = ("B", "KiB", "MiB", "GiB")


def add_verbs(verbs: Any) -> None:
    """Add the verbs of `ros2 bag`."""
    verb = add_verb(verbs, "info", "Print information about a bag to the screen", _info)
    verb.add_argument("bag_path", type=Path, help="Bag to open")
    add_flag(verb, "-t", "--topic-name", help="Only the topics' names")
    verb = add_verb(verbs, "play", "Play back ROS data from a bag", _play)
    verb.add_argument("bag_path", help="Bag to open")
    verb.add_argument("-r", "--rate", type=float, default=1.0, help="Rate at which to play back")
    add_flag(verb, "-l", "--loop", help="Play in a loop")
    verb.add_argument("--start-offset", type=float, default=0.0, help="Begin this late, in seconds")
    verb = add_verb(verbs, "record", "Record ROS data of a running swarm to a bag", _record)
    verb.add_argument("topics", nargs="*", help="Topics to be recorded")
    add_flag(verb, "-a", "--all", help="Record all topics")
    verb.add_argument("-o", "--output", default="", help="Folder of the bag")


def _info(options: argparse.Namespace) -> None:
    bag = Bag(options.bag_path)
    if options.topic_name:
        print("\n".join(sorted(bag.topics)))
        return
    rows = [
        f"Topic: {name} | Type: {topic.type} | Count: {bag.counts[name]} |"
        " Serialization Format: cdr"
        for name, topic in sorted(bag.topics.items())
    ]
    for title, value in {
        "Files": bag.path.name,
        "Bag size": _size(bag.path.stat().st_size),
        "Storage id": "mcap",
        "Duration": f"{bag.end - bag.start:.9f}s",
        "Start": _moment(bag.start),
        "End": _moment(bag.end),
        "Messages": str(sum(bag.counts.values())),
        "Topic information": ("\n" + " " * TITLE).join(rows),
    }.items():
        print(f"{title + ':':<{TITLE}}{value}")
    bag.close()


def _size(count: float) -> str:
    for unit in UNITS[:-1]:
        if count < 1024:
            return f"{count:.0f} B" if unit == "B" else f"{count:.1f} {unit}"
        count /= 1024
    return f"{count:.1f} {UNITS[-1]}"


def _moment(seconds: float) -> str:
    whole, rest = divmod(round(seconds * NANOSECONDS), NANOSECONDS)
    day = time.strftime("%b %e %Y %H:%M:%S", time.localtime(whole))
    return f"{day}.{rest:09d} ({whole}.{rest:09d})"


def _play(options: argparse.Namespace) -> None:
    words = [options.bag_path, "--ros", "--speed", str(options.rate)]
    words += ["--start", str(options.start_offset)] if options.start_offset else []
    launcher.start("swarm_replay", [*words, *(["--loop"] if options.loop else [])])


def _record(options: argparse.Namespace) -> None:
    topics = "all" if options.all or not options.topics else ",".join(options.topics)
    output = ["--output", options.output] if options.output else []
    launcher.start("swarm_commander", ["record", "--topics", topics, *output])

"""Which topics are recorded: `--record-topics` against the table of topics."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence

from swarm_common.middleware.topic_table import ROBOT_TOPICS, WORLD_TOPICS, Topic, all_topics
from swarm_common.model.errors import ConfigError

ALL = "all"
ALWAYS = ("/clock", "/map", "/sim/scene", "/sim/tf", "/sim/movers", "/sim/verdict")
DEFAULT = (
    "robot_description",
    "tf_static",
    "tf",
    "status",
    "plan",
    "local_plan",
    "scan",
    "odom",
    "cmd_vel",
    "amcl_pose",
)


def select(text: str, robots: Sequence[str]) -> list[Topic]:
    """Return the topics to record, in the order of the table.

    Args:
        text: Comma-separated names or patterns (`*`), relative to every robot (`scan`,
            `*costmap*`) or absolute (`/Srobot3/scan`, `/Srobot1*`); `all`; empty for the default.
            What a viewer needs of the world (`ALWAYS`) is recorded in any case.

    Raises:
        ConfigError: If a pattern matches nothing.
    """
    wanted = [word.strip() for word in text.split(",") if word.strip()] or list(DEFAULT)
    chosen: set[str] = set(ALWAYS)
    topics = all_topics(robots)
    for pattern in wanted:
        found = [topic.name for topic in topics if _matches(topic.name, pattern)]
        if not found:
            known = ", ".join(topic.name for topic in (*WORLD_TOPICS, *ROBOT_TOPICS))
            raise ConfigError(
                f"--record-topics: '{pattern}' matches no topic; known are {known},"
                f" each also with a robot before it, like /{next(iter(robots), 'NAME')}/scan"
            )
        chosen.update(found)
    return [topic for topic in topics if topic.name in chosen]


def select_of(text: str, robot: str) -> list[Topic]:
    """Return the topics to record of a robot that has come later; see `select`."""
    wanted = [word.strip() for word in text.split(",") if word.strip()] or list(DEFAULT)
    return [
        topic
        for topic in all_topics([robot])
        if topic.name.startswith(f"/{robot}/")
        and any(_matches(topic.name, pattern) for pattern in wanted)
    ]


def _matches(name: str, pattern: str) -> bool:
    if pattern == ALL:
        return True
    if pattern.startswith("/"):
        return fnmatch.fnmatchcase(name, pattern)
    relative = name.split("/", 2)[-1]
    return not name.startswith("/sim/") and fnmatch.fnmatchcase(relative, pattern)

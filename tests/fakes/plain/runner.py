"""Fake of the mission process without ROS: reaches every goal at once, or as its mood is."""

import json
import os
import sys
import time
from pathlib import Path

config = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
flags = dict(zip(sys.argv[2::2], sys.argv[3::2], strict=True))
event_fd = int(flags["--event-fd"])


def say(event: str, **values: object) -> None:
    os.write(event_fd, json.dumps({"event": event, **values}).encode() + b"\n")


while not (Path(sys.argv[1]).parent / "active").exists():
    time.sleep(0.02)
time.sleep(0.3)  # what the navigators said has arrived by then
mood = os.environ.get("FAKE_RUNNER", "")
begun = Path(sys.argv[1]).parent / "begun"
if mood == "dies" and not begun.exists():  # when it has sent a goal, and all were active for long
    begun.touch()
    say("mission", goals=len(config["robots"]))
    say("sent", robot=config["robots"][0]["name"], goal="shipping")
    time.sleep(4.0)
    sys.exit(1)
if mood == "dies":
    time.sleep(1.0)
if mood != "mute":
    say("swarm_heard")
if config["mission"] is not None and mood != "mute":
    say("mission", goals=len(config["robots"]))
    for robot in config["robots"]:
        say("sent", robot=robot["name"], goal="shipping")
        if mood == "slow":
            begun.touch()
            break
        goal = {"robot": robot["name"], "goal": "shipping", "sim_time": 10.0}
        if mood == "miss":
            say("missed", missed=goal | {"reason": "error 208: every way is closed [by walls]"})
        else:
            say("reached", **goal, duration=8.0)
    if mood != "slow":
        say("done")
while True:
    say("alive")
    time.sleep(1.0)

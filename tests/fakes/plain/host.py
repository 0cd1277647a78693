"""Fake of the navigators' process without ROS."""

import json
import os
import sys
import time
from pathlib import Path

from swarm_common.process.lifetime import die_with

_, config_path, wait, *rest = sys.argv
assert wait == "--wait"
flags = dict(zip(rest[::2], rest[1::2], strict=True))
event_fd = int(flags["--event-fd"])
if os.read(int(flags["--control-fd"]), 1000) != b'{"cmd":"go"}\n':
    sys.exit(0)
config = json.loads(Path(config_path).read_text(encoding="utf-8"))
mood = os.environ.get("FAKE_HOST", "")


def say(event: str, **values: object) -> None:
    os.write(event_fd, json.dumps({"event": event, **values}).encode() + b"\n")


if mood == "refuse":
    say("error", message=f"{config['robots'][0]['params']}: max_vel_x is -1; it must be positive")
    sys.exit(2)
for robot in config["robots"]:
    assert Path(robot["params"]).is_file()
    fork_server = os.getpid()
    if os.fork() == 0:
        die_with(fork_server)
        while True:
            time.sleep(1.0)
    if mood != "mute":
        say("active", robot=robot["name"], pid=0)
(Path(config_path).parent / "active").touch()
if mood in ("death", "deaths"):
    say("died", robot="Srobot2", returncode=-9)
deaths = 0
while True:
    command = os.read(int(flags["--control-fd"]), 1000)
    if mood == "deaths" and json.loads(command)["cmd"] == "start":
        say("forked", robot="Srobot2", pid=0)
        say("active", robot="Srobot2", pid=0)
        say("died", robot="Srobot2", returncode=-9)
        deaths += 1
        if deaths == 5:
            (Path(config["log_dir"]) / "deaths").touch()

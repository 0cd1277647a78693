"""Fake of the world process without ROS: says what the real one says, as its mood demands."""

import json
import os
import signal
import sys
import threading
import time
from pathlib import Path

config = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
flags = dict(zip(sys.argv[2::2], sys.argv[3::2], strict=True))
event_fd = int(flags["--event-fd"])
mood = os.environ.get("FAKE_WORLD", "")
COLLISION = {
    "robots": ["Srobot1", "Srobot3"],
    "obstacle": "",
    "x": 1.0,
    "y": -2.0,
    "sim_time": 11.4,
}


def say(event: str, **values: object) -> None:
    os.write(event_fd, json.dumps({"event": event, **values}).encode() + b"\n")


def end(*_: object) -> None:
    if mood != "silent":
        robots = {
            robot["name"]: {"distance": 1.0, "collisions": 0, "min_clearance": None}
            for robot in config["robots"]
        }
        verdict = {
            "sim_time": 12.0,
            "robot_robot": 1 if mood == "collision" else 0,
            "robot_world": 0,
            "min_clearance": 0.25,
            "real_time_factor": 6.0,
            "late_ticks": 0,
            "trajectory_sha256": "ab" * 32,
            "near_misses": 2,
            "collisions": [COLLISION] if mood == "collision" else [],
            "robots": robots,
        }
        Path(config["verdict_path"]).write_text(json.dumps(verdict), encoding="utf-8")
    sys.exit(0)


def wait_for_mark(name: str) -> None:
    while not (Path(sys.argv[1]).parent / name).exists():
        time.sleep(0.1)


def stop_once_active() -> None:
    wait_for_mark("active")
    time.sleep(1.0)
    os.kill(os.getpid(), signal.SIGSTOP)


signal.signal(signal.SIGTERM, end)
if mood == "refuse":
    say("error", message="station loader_3 lies inside a wall")
    sys.exit(2)
say("spawn", poses=[[float(i), 0.0, 0.0] for i in range(len(config["robots"]))])
say("ready")
if mood == "collision":
    say("collision", collision=COLLISION)
if mood == "crash":
    sys.stderr.write("the physics engine fell over\n")
    sys.exit(7)
if mood == "deaf":
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
while config["held"] and b'"begin"' not in os.read(int(flags["--control-fd"]), 4096):
    pass
if config["duration"] is not None:
    wait_for_mark("begun" if mood == "calm" else "active")
    time.sleep(0.5)  # what the mission or the navigators said has arrived by then
    if mood != "early":
        say("over")
    end()
if mood == "stopped":
    threading.Thread(target=stop_once_active, daemon=True).start()
while True:
    collisions = {"robot_robot": 0, "robot_world": 0}
    say("progress", sim_time=11.0, real_time_factor=5.0, collisions=collisions)
    time.sleep(0.2)

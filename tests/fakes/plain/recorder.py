"""Fake of the recorder whose disk is full, which hangs, or which has lost messages."""

import json
import os
import signal
import sys

flags = dict(zip(sys.argv[2::2], sys.argv[3::2], strict=True))
if os.environ.get("FAKE_RECORDER") == "hangs":
    os.kill(os.getpid(), signal.SIGSTOP)
if os.environ.get("FAKE_RECORDER") == "lacks":
    lost = {"messages": 12, "lost": {"/map": 1, "/Srobot1/odom": 7}, "missing": ["/map"]}
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])
    os.write(int(flags["--event-fd"]), b'{"event": "recording", "path": "x", "topics": 3}\n')
    signal.sigwait([signal.SIGTERM])
    line = json.dumps({"event": "recorded", "path": "x", **lost})
    os.write(int(flags["--event-fd"]), line.encode() + b"\n")
    sys.exit(0)
event = {"event": "error", "message": "recording: No space left on device"}
os.write(int(flags["--event-fd"]), json.dumps(event).encode() + b"\n")
sys.exit(2)

"""Fake of the recorder whose disk is full, or which hangs."""

import json
import os
import signal
import sys

flags = dict(zip(sys.argv[2::2], sys.argv[3::2], strict=True))
if os.environ.get("FAKE_RECORDER") == "hangs":
    os.kill(os.getpid(), signal.SIGSTOP)
event = {"event": "error", "message": "recording: No space left on device"}
os.write(int(flags["--event-fd"]), json.dumps(event).encode() + b"\n")
sys.exit(2)

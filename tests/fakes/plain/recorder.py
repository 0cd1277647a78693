"""Fake of the recorder whose disk is full."""

import json
import os
import sys

flags = dict(zip(sys.argv[2::2], sys.argv[3::2], strict=True))
event = {"event": "error", "message": "recording: No space left on device"}
os.write(int(flags["--event-fd"]), json.dumps(event).encode() + b"\n")
sys.exit(2)

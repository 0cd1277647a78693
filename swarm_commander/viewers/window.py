"""Becomes a program with a window: `python -m swarm_commander.viewers.window CONFIG.json`.

Programs of others do not know the flags that swarm-up gives its processes; here they are dropped.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

if __name__ == "__main__":
    command = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))["command"]
    os.execv(command[0], command)

"""A mosquitto of our own on loopback, for `--vda5050 embedded`."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

from swarm_common.model.errors import ConfigError
from swarm_common.process.lifetime import die_with

START_LIMIT = 5.0  # [s] for it to answer
CONFIG = """listener {port} 127.0.0.1
allow_anonymous true
persistence false
message_size_limit 1100000
"""


def find_mosquitto() -> str:
    """Return the path of the program.

    Raises:
        ConfigError: If it is not installed.
    """
    path = os.environ.get("PATH", "") + os.pathsep + "/usr/sbin"  # where Debian has it
    program = shutil.which("mosquitto", path=path)
    if program is None:
        raise ConfigError(
            "--vda5050 embedded needs the program mosquitto, which is not installed: install it"
            " (Debian: apt-get install mosquitto), or give the URL of another broker"
        )
    return program


class Broker:
    """A running mosquitto; it ends with this process."""

    def __init__(self, port: int, folder: Path) -> None:
        """Start it, and wait until it answers.

        Args:
            port: TCP port on loopback.
            folder: For its configuration and its log.

        Raises:
            ConfigError: If it does not start.
        """
        self.port = port
        config, self._log = folder / "mosquitto.conf", folder / "mosquitto.log"
        config.write_text(CONFIG.format(port=port), encoding="utf-8")
        parent = os.getpid()
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(
                (find_mosquitto(), "-c", str(config)),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                preexec_fn=lambda: die_with(parent),
            )
        self._await()

    def _await(self) -> None:
        end = time.monotonic() + START_LIMIT
        while time.monotonic() < end and self._process.poll() is None:
            try:
                with socket.create_connection(("127.0.0.1", self.port), timeout=1.0):
                    time.sleep(0.05)  # an address in use is noticed after another's answer
                    if self._process.poll() is None:
                        return
            except OSError:
                time.sleep(0.05)
        self.stop()
        raise ConfigError(
            f"the broker does not start on port {self.port}, which another may have (see"
            f" {self._log}); give another port with embedded:PORT, or the broker's URL"
        )

    def stop(self) -> None:
        """End it."""
        self._process.terminate()
        self._process.wait()

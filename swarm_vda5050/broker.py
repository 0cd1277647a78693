"""A broker of our own on loopback, for `--vda5050 embedded`: mosquitto, or else amqtt."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from pathlib import Path

from swarm_common.model.errors import ConfigError
from swarm_common.process.lifetime import die_with
from swarm_run.fleet_link import check_free, find_mosquitto

START_LIMIT = 15.0  # [s] for it to answer
CONFIG = """listener {port} 127.0.0.1
allow_anonymous true
persistence false
user root
"""  # as root it would go over to another user, and Linux then lets it outlive us, see prctl(2)
CONFIG_OF_AMQTT = """listeners:
  default: {{type: tcp, bind: "127.0.0.1:{port}"}}
plugins:
  amqtt.plugins.authentication.AnonymousAuthPlugin: {{allow_anonymous: true}}
"""
AMQTT = (sys.executable, "-m", "amqtt.scripts.broker_script")


class Broker:
    """A running broker; it ends with this process."""

    def __init__(self, port: int, folder: Path) -> None:
        """Start it, and wait until it answers.

        Args:
            folder: For its configuration and its log; it must exist.

        Raises:
            ConfigError: If it does not start.
        """
        check_free(port)
        self.port = port
        program = find_mosquitto()
        self._command = (program,) if program else AMQTT
        text = CONFIG if program else CONFIG_OF_AMQTT
        self._config, self._log = folder / "mqtt_broker.conf", folder / "mqtt_broker.log"
        self._config.write_text(text.format(port=port), encoding="utf-8")
        self._process = self._start()
        self._await()

    def revive(self) -> bool:
        """Start it again if it ended; return whether it had."""
        if self._process.poll() is None:
            return False
        self._process = self._start()
        return True

    def _start(self) -> subprocess.Popen[bytes]:
        parent = os.getpid()
        with self._log.open("ab") as log:
            return subprocess.Popen(
                (*self._command, "-c", str(self._config)),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                preexec_fn=lambda: die_with(parent),
            )

    def _await(self) -> None:
        end = time.monotonic() + START_LIMIT
        while time.monotonic() < end and self._process.poll() is None:
            try:
                with socket.create_connection(("127.0.0.1", self.port), timeout=1.0):
                    return
            except OSError:
                time.sleep(0.05)
        self.stop()
        raise ConfigError(
            f"the broker does not start on port {self.port} (see {self._log}); give another with"
            " embedded:PORT, or the broker's URL"
        )

    def stop(self) -> None:
        """End it."""
        self._process.terminate()
        self._process.wait()

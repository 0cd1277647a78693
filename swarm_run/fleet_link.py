"""How the robots of a swarm reach a fleet control that speaks VDA 5050: options of `swarm-up`."""

from __future__ import annotations

import importlib.util
import ipaddress
import os
import shutil
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from swarm_common.model.errors import ConfigError, UnknownNameError

EMBEDDED = "embedded"  # a broker of our own, on loopback
PORT, SECURE_PORT = 1883, 8883
VERSIONS = ("2.0", "2.1", "3.0")
CHECKS = ("strict", "lenient")
FAULTS = (  # on demand
    "simEmergencyStop", "simOperatingMode", "simFailAction", "simLoseLocation", "simError",
    "simBattery", "simIgnoreOrder", "simBreakConnection", "simSlowState", "simEnd",
)  # fmt: skip
EXPECTED = "mqtt://HOST:PORT, mqtts://HOST:PORT or embedded"
NOT_IN_TOPICS = "/+#\0"


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetLink:
    """Broker, name and version, checked."""

    url: str
    manufacturer: str = "swarm"
    version: str = "2.1"
    interface: str = ""  # first level of topics; empty for the version's
    check: str = ""  # one of CHECKS; empty for no verdict
    faults: tuple[Mapping[str, Any], ...] = ()  # on demand: at, robot, fault and its parameters
    user: str = ""
    ca: Path | None = None  # certificates to trust, with mqtts; None for the system's

    def __post_init__(self) -> None:
        if self.version not in VERSIONS:
            raise UnknownNameError("VDA 5050 version", self.version, VERSIONS)
        if self.check and self.check not in CHECKS:
            raise UnknownNameError("check", self.check, CHECKS, "--vda5050-check")
        for flag, name in (
            ("--manufacturer", self.manufacturer),
            ("--vda5050-interface", self.interface or "uagv"),
        ):
            if not name or set(name) & set(NOT_IN_TOPICS):
                raise ConfigError(f"{flag} is '{name}'; expected a name without / + #")
        for number, each in enumerate(self.faults, 1):
            lacks = {"at", "robot", "fault"} - set(each)
            if lacks or not isinstance(each.get("at"), int | float):
                raise ConfigError(
                    f"vda5050_faults: entry {number} is {dict(each)}; expected at (in s), robot,"
                    " fault, and the parameters of the fault"
                )
            if each["fault"] not in FAULTS:
                raise UnknownNameError("fault", str(each["fault"]), FAULTS, "vda5050_faults")
        if self.ca is not None and not self.ca.is_file():
            raise ConfigError(f"--vda5050-ca: there is no file {self.ca}")
        if self.ca is not None and not self._is_secure:
            raise ConfigError("--vda5050-ca is for a broker with TLS: mqtts://HOST:PORT")
        if self.is_embedded:
            find_mosquitto()
        host, _ = self._parts
        if not self.user and not _is_loopback(host):
            raise ConfigError(
                f"--vda5050 {self.url} leaves this machine; give --vda5050-user NAME, and the"
                " password in SWARM_VDA5050_PASSWORD"
            )
        if importlib.util.find_spec("paho") is None:
            raise ConfigError("--vda5050 needs paho-mqtt: pip install swarm-workbench[vda5050]")

    @property
    def is_embedded(self) -> bool:
        """Whether we start the broker."""
        return self.url.split(":")[0] == EMBEDDED

    @property
    def _is_secure(self) -> bool:
        return self.url.startswith("mqtts://")

    @property
    def _parts(self) -> tuple[str, int]:
        """Host and port of the URL."""
        url = self.url
        if self.is_embedded:
            url = f"mqtt://127.0.0.1{url.removeprefix(EMBEDDED)}"
        try:
            parts = urlsplit(url)
            given = parts.port
        except ValueError as error:
            raise ConfigError(f"--vda5050 is '{self.url}': {error}; expected {EXPECTED}") from None
        is_bare = not (parts.username or parts.password or parts.path.strip("/") or parts.query)
        is_known = parts.scheme in ("mqtt", "mqtts") and bool(parts.hostname)
        if not is_known or not is_bare or given == 0:
            raise ConfigError(f"--vda5050 is '{self.url}'; expected {EXPECTED}")
        return str(parts.hostname), given or (SECURE_PORT if self._is_secure else PORT)

    def config(self) -> dict[str, Any]:
        """Return what the process of the vehicles needs to know."""
        host, port = self._parts
        return {
            "embedded": self.is_embedded,
            "manufacturer": self.manufacturer,
            "version": self.version,
            "interface": self.interface,
            "check": self.check,
            "faults": [dict(each) for each in self.faults],
            "broker": {
                "host": host,
                "port": port,
                "user": self.user,
                "is_secure": self._is_secure,
                "ca": str(self.ca.absolute()) if self.ca else "",
            },
        }


def find_mosquitto() -> str | None:
    """Return the path of the program; None if it is not installed and amqtt has to do.

    Raises:
        ConfigError: If neither is installed.
    """
    path = os.environ.get("PATH", "") + os.pathsep + "/usr/sbin"  # where Debian has it
    program = shutil.which("mosquitto", path=path)
    if program is None and importlib.util.find_spec("amqtt") is None:
        raise ConfigError(
            "--vda5050 embedded needs the program mosquitto, which is not installed: install it"
            " (Debian: apt-get install mosquitto; or pip install swarm-workbench[broker]), or give"
            " the URL of another broker"
        )
    return program


def fleet_link(url: str | None, manufacturer: str | None, **more: Any) -> FleetLink | None:
    """Return the link as typed; None without --vda5050.

    Args:
        more: Further fields of `FleetLink`; None for what is not given.

    Raises:
        ConfigError: If an option is given that needs --vda5050, or one is wrong.
    """
    given = {"manufacturer": manufacturer, **more}
    typed = {name: value for name, value in given.items() if value is not None}
    if url is None:
        if typed:
            name = next(iter(typed))
            flag = "--manufacturer" if name == "manufacturer" else f"--vda5050-{name}"
            raise ConfigError(f"{flag} needs --vda5050, like --vda5050 mqtt://localhost:1883")
        return None
    link = FleetLink(url=url, **typed)
    if link.is_embedded:
        check_free(link.config()["broker"]["port"])
    return link


def check_free(port: int) -> None:
    """Refuse a port for our broker that another program has, before anything is started.

    Raises:
        ConfigError: If it is taken or not allowed.
    """
    try:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(("127.0.0.1", port))
    except OSError as error:
        raise ConfigError(
            f"--vda5050 embedded cannot use port {port}: {error.strerror}; give another with"
            " embedded:PORT, or the URL of the broker that has it, like mqtt://localhost:1883"
        ) from None


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False

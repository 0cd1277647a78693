"""The maps of one robot: downloaded, enabled and deleted as a fleet control wants."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple
from urllib.parse import urlsplit

from swarm_vda5050.faults import ActiveError
from swarm_vda5050.messages import MapState

WORLD_VERSION = "1"  # of the map with which a run begins
MOST_MAPS = 20
SCHEMES = ("http", "https", "file")  # of links
DIGESTS = {32: "md5", 40: "sha1", 64: "sha256", 96: "sha384", 128: "sha512"}  # by hex digits


class Download(NamedTuple):
    """A map or a zone set that is to be fetched."""

    action_id: str
    link: str
    digest: str  # of the file, in hex; empty for any
    is_map: bool = True

    @property
    def problem(self) -> str:
        """Why it cannot be fetched; empty if it is worth a try."""
        what = "map" if self.is_map else "zoneSet"
        try:
            scheme = urlsplit(self.link).scheme
        except ValueError:
            scheme = ""
        if scheme not in SCHEMES:
            return f"{what}DownloadLink is '{self.link:.200}'; expected {', '.join(SCHEMES)}"
        if self.digest and len(self.digest) not in DIGESTS:
            names = ", ".join(name.upper() for name in DIGESTS.values())
            return f"{what}Hash has {len(self.digest)} characters; expected hex of {names}"
        return ""


@dataclass(slots=True)
class MapKeeper:
    """Maps that a robot has, all of the one area in which it drives.

    Attributes:
        map_id: Id of the area.
        enabled: Version in use.
        errors: Errors that are active, until a map is asked for anew.
    """

    map_id: str
    enabled: str = WORLD_VERSION
    errors: list[ActiveError] = field(default_factory=list)
    _versions: list[str] = field(default_factory=lambda: [WORLD_VERSION])

    def has(self, map_id: str, version: str) -> bool:
        """Whether the robot has a map."""
        return map_id == self.map_id and version in self._versions

    def problem_of(self, map_id: str, download: Download, under_way: int) -> str:
        """Return why a map cannot be downloaded; empty if it is worth a try.

        Args:
            under_way: Number of downloads, with this one.
        """
        if map_id != self.map_id:
            return f"the map '{map_id:.80}' is of another area; this world has '{self.map_id}' only"
        if download.problem:
            return download.problem
        if len(self._versions) + under_way > MOST_MAPS:
            return f"the robot keeps at most {MOST_MAPS} maps"
        return ""

    def add(self, version: str) -> None:
        """Keep a map that was downloaded, not enabled."""
        if version not in self._versions:
            self._versions.append(version)

    def enable(self, map_id: str, version: str) -> str:
        """Use a map in place of the one before; return what is wrong, if anything."""
        if not self.has(map_id, version):
            return self._lacks(map_id, version)
        self.enabled = version
        return ""

    def delete(self, map_id: str, version: str) -> str:
        """Forget a map that is not in use; return what is wrong, if anything."""
        if not self.has(map_id, version):
            return self._lacks(map_id, version)
        if version == self.enabled:
            return f"the map '{map_id:.80}' of version {version:.40} is in use"
        self._versions.remove(version)
        return ""

    def _lacks(self, map_id: str, version: str) -> str:
        known = ", ".join(self._versions)
        return (
            f"there is no map '{map_id:.80}' of version {version:.40}; this robot has"
            f" '{self.map_id}' of {known}"
        )

    @property
    def states(self) -> tuple[MapState, ...]:
        """The maps, for the fleet control."""
        return tuple(
            MapState(
                map_id=self.map_id,
                map_version=version,
                map_status="ENABLED" if version == self.enabled else "DISABLED",
            )
            for version in self._versions
        )

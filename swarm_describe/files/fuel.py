"""Models and worlds of Gazebo Fuel that `gz fuel download` or Gazebo left in the user's cache."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlparse

CACHES = (".gz/fuel", ".ignition/fuel")  # in the home folder
VARIABLES = ("GZ_FUEL_CACHE_PATH", "IGN_FUEL_CACHE_PATH")  # of another cache
SERVERS = ("fuel.gazebosim.org", "fuel.ignitionrobotics.org")  # two names of one server
URI = re.compile(
    r"/([^/]+)/(models|worlds)/([^/]+?)(?:/(tip|\d+))?(?:/files(?:/(.*))?)?/?$", re.IGNORECASE
)


@dataclass(frozen=True, slots=True)
class FuelName:
    """Name of a resource, as a URI of Fuel states it."""

    server: str
    owner: str
    kind: str  # models or worlds
    name: str
    version: str  # a number, `tip` or empty
    inside: str  # path of a file in it; empty for the whole folder

    def cached(self, home: Path, environ: Mapping[str, str]) -> Iterator[Path]:
        """Yield where it is in the caches: the version that is named, or else the newest there."""
        given = [Path(environ[name]) for name in VARIABLES if environ.get(name)]
        caches = [*given, *(home / cache for cache in CACHES)]
        others = [other for other in SERVERS if other != self.server]
        servers = [self.server, *(others if self.server in SERVERS else [])]
        places = [cache / server for cache in caches for server in servers]
        for part in (self.owner, self.kind, self.name):
            places = [folder for place in places for folder in _folders_called(part, place)]
        if self.version in ("", "tip"):
            every = [folder for place in places for folder in place.iterdir()]
            numbers = {folder: int(folder.name) for folder in every if folder.name.isdecimal()}
            newest = max(numbers.values(), default=0)
            versions = [folder for folder, number in numbers.items() if number == newest]
        else:
            versions = [
                folder for place in places for folder in _folders_called(self.version, place)
            ]
        yield from (folder / self.inside for folder in versions)
        if not versions:  # for messages
            usual = caches[0] / self.server / self.owner.lower() / self.kind / self.name.lower()
            yield usual / (self.version or "tip") / self.inside


def name_in_fuel(uri: str) -> FuelName | None:
    """Return the name in a URI of Fuel; None if it is no such URI.

    Args:
        uri: `https://fuel.gazebosim.org/1.0/OWNER/models/NAME[/VERSION][/files/PATH]`.
    """
    url = urlparse(uri.strip())
    match = URI.search(url.path)
    if url.scheme not in ("http", "https") or match is None:
        return None
    owner, kind, name, version, inside = (unquote(part or "") for part in match.groups())
    steps = [step for step in inside.split("/") if step not in ("", ".", "..")]
    return FuelName(url.netloc.lower(), owner, kind.lower(), name, version.lower(), "/".join(steps))


def _folders_called(name: str, parent: Path) -> list[Path]:
    """Return the folders of a name: Fuel does not tell upper from lower case, nor ' ' from %20."""
    if not parent.is_dir():
        return []
    folders = (folder for folder in sorted(parent.iterdir()) if folder.is_dir())
    return [folder for folder in folders if unquote(folder.name).lower() == name.lower()]

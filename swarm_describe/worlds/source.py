"""SDF files as elements: parsing, versions, files that are missing, and what is ignored."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers.expat import ExpatError

from swarm_common.model.errors import DescriptionError, RobotModelError, WorldError
from swarm_describe.files.model_paths import ModelPaths
from swarm_describe.files.packages import PackageFinder
from swarm_describe.files.xacro_io import expand
from swarm_describe.files.xml_reader import read_xml

OLDEST, NEWEST = (1, 4), (1, 10)  # versions of SDF
LATER = ((1, 11), (1, 12))  # read as if they were the newest, with a note
NAMED_SEARCHES = 12  # places that a message lists
NO_XML = (
    "worlds are Gazebo's .sdf and .world; of a world of Stage, give the picture of its floor plan "
    "to swarm-map new"
)
XACRO = "xacro:"  # how the elements of its macros begin
XACRO_ENDING = ".xacro"


@dataclass(slots=True)
class Source:
    """Findings while a world file and the files that it includes are read."""

    path: Path  # the world file
    paths: ModelPaths  # where further files are searched
    skip_missing: bool = False  # whether what is missing is left out instead of refused
    skip_broken: bool = False  # whether models that are unusable are
    ignored: Counter[str] = field(default_factory=Counter)  # number of elements left out, by tag
    # notes on elements that have no place where they stand, by their tag and what they are in
    rejected: defaultdict[tuple[str, str], list[str]] = field(
        default_factory=lambda: defaultdict(list)
    )
    remarks: list[str] = field(default_factory=list)  # other notes
    # what refers to a file that is nowhere, by URI
    missing: dict[str, str] = field(default_factory=dict)
    searched: list[str] = field(default_factory=list)  # where these were searched
    broken: dict[str, str] = field(default_factory=dict)  # why models are unusable, by name

    def find(self, uri: str, here: Path, user: str) -> Path | None:
        """Return the file of a URI; if it is nowhere, remember that and return None."""
        found = self.paths.find(uri, here)
        if found is None:
            self.missing.setdefault(uri, user)
            name = uri.rpartition("://")[2]
            for candidate in self.paths.candidates(uri, here):
                place = str(candidate).removesuffix(name).rstrip("/") or "/"
                if place not in self.searched:
                    self.searched.append(place)
        return found

    def reject(self, tag: str, kind: str, what: str, advice: str) -> None:
        """Count an element that has no place where it stands.

        Args:
            kind: Kind of the parent; equal tags in elements of one kind are one note.
        """
        self.rejected[tag, kind].append(f"{what} is ignored; {advice}")

    def remark(self, text: str) -> None:
        """Add a note, once."""
        if text not in self.remarks:
            self.remarks.append(text)

    def break_off(self, model: str, cause: DescriptionError) -> None:
        """Record that a model is unusable; `check` rejects it, or leaves it out."""
        self.broken.setdefault(model, str(cause))

    def check(self) -> None:
        """Refuse missing files and unusable models, all at once.

        Raises:
            WorldError: If there are any and they are not to be left out.
        """
        problems = [*self._missing(), *self._broken()]
        if problems:
            raise WorldError("\n".join(problems))

    def _broken(self) -> list[str]:
        if self.skip_broken:
            for model, cause in self.broken.items():
                self.remark(f"left out, because it is unusable: {model}: {cause}")
            return []
        if not self.broken:
            return []
        causes = [f"  {model}: {cause}" for model, cause in self.broken.items()]
        count = "1 model is" if len(causes) == 1 else f"{len(causes)} models are"
        hint = "mend them, or leave them out with --skip-broken"
        return [f"{self.path}: {count} unusable:", *causes, hint]

    def _missing(self) -> list[str]:
        if not self.missing:
            return []
        files = [f"  {uri}  ({user})" for uri, user in self.missing.items()]
        if self.skip_missing:
            self.remark(f"left out, because the file is missing: {', '.join(self.missing)}")
            return []
        places = self.searched[:NAMED_SEARCHES]
        more = len(self.searched) - len(places)
        return [
            f"{self.path}: {len(files)} file{'s are' if len(files) > 1 else ' is'} missing:\n"
            + "\n".join(files)
            + "\nsearched in:\n"
            + "\n".join(f"  {place}" for place in places)
            + (f"\n  and {more} more places" if more else "")
            + "\nput them there, add their folder to GZ_SIM_RESOURCE_PATH, or leave them out "
            "with --skip-missing"
        ]

    def notes(self) -> tuple[str, ...]:
        """Return notes for the user on what was read."""
        counts = ", ".join(f"{count} <{tag}>" for tag, count in sorted(self.ignored.items()))
        told = [f"ignored: {counts}"] if counts else []
        for notes in self.rejected.values():
            more = f" ({len(notes) - 1} more like it)" if len(notes) > 1 else ""
            told.append(f"{notes[0]}{more}")
        return tuple(f"{self.path.name}: {note}" for note in [*told, *self.remarks])


def parse_sdf(path: Path, source: Source) -> ET.Element:
    """Return the outermost element of an SDF file, xacro expanded."""
    root = parse_xml(path, source)
    if path.suffix == XACRO_ENDING or is_xacro(root):
        root = _expanded(path)
    check_sdf(root, path, source)
    return root


def parse_xml(path: Path, source: Source) -> ET.Element:
    """Return the outermost element of an XML file."""
    try:
        return parse_text(path.read_bytes(), path, source)
    except OSError as cause:
        raise WorldError(f"cannot read {path}: {cause}") from cause


def parse_text(data: bytes, path: Path, source: Source) -> ET.Element:
    """Return the outermost element of XML."""
    try:
        file = read_xml(data)
    except ExpatError as cause:
        if not data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith((b"<", b"\xff\xfe", b"\xfe\xff")):
            raise WorldError(f"{path} is no XML; {NO_XML}") from cause
        place = f"{path}, line {cause.lineno}, column {cause.offset}"
        raise WorldError(f"{place}: malformed XML: {cause}") from cause
    except (ValueError, LookupError) as cause:  # of the text, or of its encoding
        raise WorldError(f"cannot read {path}: {cause}") from cause
    if file.outside:
        source.remark(f"the text around <{file.root.tag}> in {path.name} is ignored")
    return file.root


def is_xacro(root: ET.Element) -> bool:
    """Return whether a document is to be expanded by xacro."""
    return "xmlns:xacro" in root.attrib or any(e.tag.startswith(XACRO) for e in root.iter())


def _expanded(path: Path) -> ET.Element:
    try:
        text = expand(path, {}, PackageFinder([], path), "give it a default= in the file")
        return read_xml(text.encode()).root
    except RobotModelError as cause:
        raise WorldError(str(cause)) from cause


def check_sdf(root: ET.Element, path: Path, source: Source) -> None:
    """Check the outermost element of an SDF file."""
    if root.tag != "sdf":
        hint = "; is it a URDF? then it is a --robot" if root.tag == "robot" else ""
        raise WorldError(f"{path}: the outermost element is <{root.tag}>; expected <sdf>{hint}")
    version = version_of(root, path)
    if version in LATER:
        source.remark(f"SDF {version[0]}.{version[1]} is read as {NEWEST[0]}.{NEWEST[1]}")


def version_of(root: ET.Element, path: Path) -> tuple[int, int]:
    """Return the version that an `<sdf>` element states."""
    text = root.get("version")
    match = re.fullmatch(r"\s*(\d{1,4})\.(\d{1,4})(\.\d+)?\s*", text or "")
    version = (int(match.group(1)), int(match.group(2))) if match else (0, 0)
    if not (OLDEST <= version <= NEWEST or version in LATER):
        given = f"version '{text}'" if text is not None else "no version"
        raise WorldError(
            f"{path}: <sdf> has {given}; expected {OLDEST[0]}.{OLDEST[1]} to "
            f'{NEWEST[0]}.{NEWEST[1]}, for example <sdf version="1.7">'
        )
    return version

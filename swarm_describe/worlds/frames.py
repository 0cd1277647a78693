"""Frames of an SDF file: `relative_to`, `<frame>`, and names inside nested models."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

from swarm_common.model.errors import DescriptionError, close_names
from swarm_common.model.shapes import Transform
from swarm_describe.files.values import pose_of, text_of, transform_of

OWN_NAMES = ("", "__model__", "world", "__root__")  # of a scope's own frame
SEPARATOR = "::"


@dataclass(slots=True)
class Scope:
    """The frames inside one model, or inside the world."""

    where: str  # name of it, for messages
    # pose of each frame, and the frame that this pose refers to
    frames: dict[str, tuple[Transform, str]] = field(default_factory=dict)
    # scopes of the models inside; they stand at the frames of the same names
    inner: dict[str, Scope] = field(default_factory=dict)
    # scopes whose names count as names of this one, and where they stand
    merged: list[str] = field(default_factory=list)
    _known: dict[str, Transform] = field(default_factory=dict)
    _open: list[str] = field(default_factory=list)

    def add(self, element: ET.Element, base: str = "") -> None:
        """Add the frame of an element with a name and a pose.

        Args:
            base: Frame that the pose refers to unless it names another.
        """
        name = element.get("name", "")
        where = f"{self.where}::{name}" if self.where else name
        self.frames.setdefault(name, (pose_of(element, where), base_of(element, self, base)))

    def add_all(self, model: ET.Element) -> None:
        """Add the frames of a model: its links, its joints, and those that have only a name."""
        for link in model.findall("link"):
            self.add(link)
        for joint in model.findall("joint"):
            self.add(joint, text_of(joint, "child"))
        for frame in model.findall("frame"):
            self.add(frame, frame.get("attached_to", ""))

    def placed(self, element: ET.Element, where: str) -> Transform:
        """Return an element's pose in the frame of this scope."""
        pose = pose_of(element, where)
        base = base_of(element, self, "")
        return pose if base in OWN_NAMES else self.frame(base) @ pose

    def frame(self, name: str) -> Transform:
        """Return where a frame is in the frame of this scope.

        Args:
            name: May lead into nested models: `model::link`.
        """
        if name in OWN_NAMES:
            return transform_of(None, self.where)
        if name in self._known:
            return self._known[name]
        if name in self._open:
            chain = " -> ".join([*self._open[self._open.index(name) :], name])
            raise DescriptionError(f"the poses in {self.where or 'the world'} go round: {chain}")
        self._open.append(name)
        try:
            self._known[name] = self._resolved(name)
        finally:
            self._open.pop()
        return self._known[name]

    def knows(self, name: str) -> bool:
        """Return whether there is a frame of this name."""
        head, _, rest = name.partition(SEPARATOR)
        if name in OWN_NAMES or name in self.frames:
            return True
        if rest and head in self.inner:
            return self.inner[head].knows(rest)
        return any(self.inner[key].knows(name) for key in self.merged)

    def _resolved(self, name: str) -> Transform:
        head, _, rest = name.partition(SEPARATOR)
        if name in self.frames:
            pose, base = self.frames[name]
            return pose if base in OWN_NAMES else self.frame(base) @ pose
        if rest and head in self.inner:
            return self.frame(head) @ self.inner[head].frame(rest)
        for key in self.merged:
            if self.inner[key].knows(name):
                return self.frame(key) @ self.inner[key].frame(name)
        close = close_names(name, self.frames, most=1)
        advice = f"did you mean '{close[0]}'?" if close else f"known: {', '.join(self.frames)}"
        raise DescriptionError(f"no frame '{name}' in {self.where or 'the world'}; {advice}")


def base_of(element: ET.Element, scope: Scope, default: str) -> str:
    """Return the name of the frame that an element's pose refers to."""
    pose = element.find("pose")
    if pose is None:
        return default
    given = pose.get("relative_to", "")
    old = pose.get("frame", "")  # until SDF 1.6; simulators ignored unknown ones
    return given or (old if old and scope.knows(old) else default)

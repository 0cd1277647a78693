"""Descriptions of things that come at run time: SDF or URDF, a file, a model's folder or a text."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np

from swarm_common.model.errors import DescriptionError, WorldError
from swarm_common.model.shapes import Part, Plane, inverse_of
from swarm_describe.files.model_paths import ModelPaths
from swarm_describe.files.packages import PackageFinder
from swarm_describe.files.xacro_io import expand
from swarm_describe.robots.description import parse_urdf
from swarm_describe.worlds.bodies import bodies_of, convex, welded
from swarm_describe.worlds.frames import Scope
from swarm_describe.worlds.grammar import account_for
from swarm_describe.worlds.models import WorldState, model_file, models_in
from swarm_describe.worlds.scene import Body
from swarm_describe.worlds.source import Source, check_sdf, is_xacro, parse_sdf, parse_text
from swarm_sim.world.request_checks import Reason, RefusedError

TEXT = "entity_resource.resource_string"  # what messages call a description without a file
FROM_FILES = "xacro is read from files only; give a uri"
SDF, URDF = "sdf", "robot"  # outermost elements
ENDINGS = {".sdf": SDF, ".world": SDF, ".urdf": URDF, ".xacro": URDF}
SDF_XACRO = (".sdf.xacro", ".world.xacro")
MOVING = re.compile(r"<joint\b[^>]*\btype\s*=\s*[\"'](continuous|revolute|prismatic)")


def is_object(uri: str, text: str, is_named_as_robot: bool, beside: Path) -> bool:
    """Return whether the requested entity is an object, and not a robot with a navigator.

    Args:
        is_named_as_robot: Whether the name that it is to have is one of a robot.
        beside: Folder of the world file, where models are searched, too.
    """
    if not uri:
        return bool(text)
    if is_named_as_robot:
        return False
    path = _path_of(uri, beside)
    if path is None:
        return uri.startswith("model://") or _is_sdf(Path(uri))
    if path.is_dir():
        return uri.startswith("model://") or _is_model(path)
    if _is_sdf(path):
        return True
    if path.suffix != ".urdf":
        return False
    return MOVING.search(path.read_text(encoding="utf-8", errors="replace")) is None


def read_object(uri: str, text: str, beside: Path) -> Body:
    """Return a thing as one body in the frame of its model.

    Args:
        uri: Path, `file://`, `model://` or `package://`; counts before the text.
    """
    try:
        path = _path_of(uri, beside) if uri else None
        if path is None and uri:
            raise RefusedError(
                Reason.NO_MODEL, f"there is no file '{uri}'; expected an .sdf, a .urdf or a model"
            )
        source = Source(path or Path(TEXT), ModelPaths(beside))
        if path is not None and path.is_dir():
            path = model_file(path, source)
        data = text.encode() if path is None else path.read_bytes()
        where = path or Path(TEXT)
        body = _read(data, where, beside, source)
    except DescriptionError as cause:
        raise RefusedError(Reason.BAD_MODEL, str(cause)) from cause
    except (OSError, UnicodeDecodeError) as cause:
        raise RefusedError(Reason.NO_MODEL, f"cannot read {uri}: {cause}") from cause
    if not body.parts:
        raise RefusedError(Reason.BAD_MODEL, f"{where}: '{body.name}' has no collision shape")
    return body


def _path_of(uri: str, beside: Path) -> Path | None:
    return ModelPaths(beside).find(uri, Path.cwd())


def _is_sdf(path: Path) -> bool:
    return ENDINGS.get(path.suffix) == SDF or path.name.endswith(SDF_XACRO)


def _is_model(folder: Path) -> bool:
    return (folder / "model.config").is_file() or (folder / "model.sdf").is_file()


def _read(data: bytes, where: Path, beside: Path, source: Source) -> Body:
    root = parse_text(data, where, source)
    if root.tag == URDF:
        return _of_urdf(data.decode(), where)
    if root.tag != SDF:
        raise RefusedError(
            Reason.BAD_FORMAT,
            f"{where}: the outermost element is <{root.tag}>; expected <sdf> or <robot>",
        )
    if is_xacro(root):
        if not where.is_file():
            raise WorldError(f"{where}: {FROM_FILES}")
        root = parse_sdf(where, source)
    return _of_sdf(root, where, beside, source)


def _of_sdf(root: ET.Element, where: Path, beside: Path, source: Source) -> Body:
    here = where.resolve().parent if where.is_file() else beside
    check_sdf(root, where, source)
    scope = Scope("")
    models = models_in(root, here, source, scope)
    if len(models) != 1 and not source.broken and not source.missing:
        raise WorldError(f"{where}: found {len(models)} <model> in <sdf>; expected one")
    account_for(root, "world", "<sdf>", source)
    bodies = [convex(body, source) for body in bodies_of(models, scope, WorldState(), source)]
    if source.missing:
        raise RefusedError(
            Reason.MISSING_FILES,
            f"{where}: missing files: {', '.join(source.missing)}; "
            f"searched in {', '.join(source.searched[:8])}",
        )
    if source.broken:
        raise WorldError(f"{where}: {'; '.join(source.broken.values())}")
    model = models[0]
    if not bodies:
        raise WorldError(f"{where}: model '{model.name}' has no link with a shape")
    whole = welded(bodies, model.is_static)
    if any(isinstance(part.shape, Plane) for part in whole.parts):
        raise WorldError(f"{where}: model '{model.name}' is a plane; the ground is there already")
    base = inverse_of(scope.frame(model.name)) @ whole.world_from_body
    parts = tuple(Part(part.shape, base @ part.body_from_part) for part in whole.parts)
    visuals = tuple(
        replace(visual, body_from_visual=base @ visual.body_from_visual) for visual in whole.visuals
    )
    return replace(whole, name=model.name, world_from_body=np.eye(4), parts=parts, visuals=visuals)


def _of_urdf(text: str, where: Path) -> Body:
    if where.suffix == ".xacro" or "xacro:" in text:
        if not where.is_file():
            raise WorldError(f"{where}: {FROM_FILES}")
        text = expand(where, {}, PackageFinder([], where))
    if MOVING.search(text):
        raise RefusedError(
            Reason.BAD_FORMAT,
            f"{where} has joints that move, so it is a robot; robots are given by uri",
        )
    model = parse_urdf(text, str(where), (), PackageFinder([], where), where.resolve().parent)
    base = model.groups[0]
    static = ET.fromstring(text.encode()).findtext("gazebo/static", "false").strip().lower()
    return Body(model.name, np.eye(4), base.parts, static in ("true", "1"), base.mass)

"""Reading of SDFormat worlds (Gazebo's `.sdf` and `.world`) into a `Scene`.

Read: models, nested and included ones, links with their collisions, looks, mass and friction,
poses with `relative_to`, `<state>`, and actors on scripts. Ignored, with a note: lights, plugins,
sensors. Ignored without one: what concerns only pictures and solvers.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError, DescriptionError, WorldError
from swarm_common.model.sites import Sites
from swarm_describe.files.model_paths import ModelPaths
from swarm_describe.worlds.actors import ACTORS_FILE, Actors, check_names, load_actors
from swarm_describe.worlds.bodies import bodies_of
from swarm_describe.worlds.floor import on_floor
from swarm_describe.worlds.frames import Scope
from swarm_describe.worlds.grammar import account_for
from swarm_describe.worlds.models import models_in, state_of
from swarm_describe.worlds.overlaps import overlaps
from swarm_describe.worlds.scene import Body, Scene
from swarm_describe.worlds.scripted_actors import actors_of
from swarm_describe.worlds.source import XACRO_ENDING, Source, parse_sdf
from swarm_describe.worlds.world_file import SITES_FILE, WORLD_FILE, find_world


@dataclass(frozen=True, slots=True)
class WorldFile:
    """Content of an SDF file."""

    bodies: tuple[Body, ...]  # all links of all models, in file order
    actors: Actors  # actors with a script
    notes: tuple[str, ...]  # elements that are ignored


def load_world(
    name_or_path: str | Path,
    *,
    skip_missing: bool = False,
    skip_broken: bool = False,
    sites: str | Path | None = None,
) -> Scene:
    """Return a world.

    Args:
        name_or_path: Name of a folder in `worlds/`, or a path to a folder, `.sdf` or `.world`,
            or to one of these in xacro.
        skip_missing: Whether models and meshes that are nowhere are left out.
        skip_broken: Whether models that are unusable are.
        sites: Path of a sites file; None for the one beside the world.

    Raises:
        UnknownNameError: If there is no such world.
        ConfigError: If the sites or actors beside it are unusable.
    """
    path = find_world(name_or_path)
    sites_path = path.with_name(SITES_FILE) if sites is None else Path(sites)
    actors_path = path.with_name(ACTORS_FILE)
    file = read_world(path, skip_missing=skip_missing, skip_broken=skip_broken)
    own = load_actors(actors_path) if actors_path.is_file() else Actors()
    walkers = (*file.actors.walkers, *own.walkers)
    vehicles = (*file.actors.vehicles, *own.vehicles)
    check_names([*walkers, *vehicles], str(path))
    named = load_sites(sites_path) if sites or sites_path.is_file() else Sites()
    solid = tuple(body for body in file.bodies if body.parts)
    file_name = path.name.removesuffix(XACRO_ENDING)
    scene = Scene(
        name=path.absolute().parent.name if file_name == WORLD_FILE else Path(file_name).stem,
        file=path,
        bodies=solid,
        sites=named,
        walkers=walkers,
        vehicles=vehicles,
        decor=tuple(body for body in file.bodies if not body.parts),
        notes=(*file.notes, *named.zones.notes),
    )
    return on_floor(scene)


def read_world(path: Path, *, skip_missing: bool = False, skip_broken: bool = False) -> WorldFile:
    """Return the content of an SDF file, and of those that it includes."""
    source = Source(path, ModelPaths(path.resolve().parent), skip_missing, skip_broken)
    root = parse_sdf(path, source)
    world = root.find("world")
    top = root if world is None else world
    try:
        if world is not None:
            account_for(root, "sdf", "<sdf>", source)
        account_for(top, "world", f"<{top.tag}>", source)
        bodies = _bodies(top, path.resolve().parent, source)
        actors = actors_of(top, source)
    except (DescriptionError, ConfigError) as cause:
        raise WorldError(f"{path}: {cause}") from cause
    solid = [body for body in bodies if body.parts]
    for model, reason in overlaps(solid).items():
        source.break_off(model, WorldError(reason))
    gone = set(source.broken)
    bodies = [body for body in bodies if body.name.partition("::")[0] not in gone]
    source.check()
    return WorldFile(tuple(bodies), actors, source.notes())


def _bodies(top: ET.Element, here: Path, source: Source) -> list[Body]:
    scope = Scope("")
    for frame in top.findall("frame"):
        scope.add(frame, frame.get("attached_to", ""))
    state = state_of(top, source)
    models = models_in(top, here, source, scope)
    for inserted in state.inserted:
        models += models_in(inserted, here, source, scope)
    return bodies_of(models, scope, state, source)

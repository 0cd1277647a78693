"""Worlds, maps and what belongs to them with faults in them: loaded, or one clear SwarmError.

A few of each run always; many with `FUZZ_EXAMPLES=10000 pytest tests/fuzz --timeout=0`.
"""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.files.map_io import load_map, save_map
from swarm_common.files.resources import share_directory
from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import SwarmError
from swarm_describe.worlds.actors import load_actors
from swarm_describe.worlds.reader import load_world
from swarm_map.floor_plan import load_plan
from swarm_map.world_writer import sdf_text, sites_text
from swarm_sim.maps.check import check_vehicles, check_walkers
from tests.fakes.gazebo_package import write_package
from tests.fakes.scenes import section_at
from tests.fuzz.byte_mutation import EDITS, FUZZ, mutated

ACTORS = b"""walkers:
  - {name: Ann, path: [[0, 0], [2, 0], [2, 1]], speed: 1.0, start: 1.5, pause: 0}
forklifts:
  - {path: [[-3, 3], [3, 3]], length: 2.0, patience: 3}
"""
SITES = (share_directory() / "worlds" / "slim_blockage" / "sites.yaml").read_bytes()
PLAN = (share_directory() / "worlds" / "warehouse" / "plan.yaml").read_bytes()
MAP = b"image: m.pgm\nmode: scale\nresolution: 0.05\norigin: [1.0, -2.0, 0.4]\nnegate: 0\n"
MAP += b"occupied_thresh: 0.65\nfree_thresh: 0.25\n"
PGM = b"P5\n# made by hand\n12 8\n255\n" + bytes(range(96))
PLAIN_PGM = b"P2\n3 2\n15\n" + b" 0 15 7\n 3 3 3\n"


def survives(use, path, data):
    """Write a file and use it; nothing but a SwarmError may come of it."""
    path.write_bytes(data)
    with suppress(SwarmError):
        use(path)


@pytest.fixture(scope="module", name="package")
def package_fixture(tmp_path_factory):
    return write_package(tmp_path_factory.mktemp("fuzz"))


def look_at(path):
    scene = load_world(path)
    section_at(scene, 0.132)
    with suppress(SwarmError):
        check_walkers(scene, scene.walkers)
        check_vehicles(scene, scene.vehicles)


def survives_with(package, file, edits):
    """Look at a world of whose files one is mutated."""
    intact = file.read_bytes()
    try:
        file.write_bytes(mutated(intact, edits))
        with suppress(SwarmError):
            look_at(package)
    finally:
        file.write_bytes(intact)


@FUZZ
@given(edits=EDITS)
def test_worlds(package, edits):
    world = package.with_name("mutated.world")
    survives(look_at, world, mutated(package.read_bytes(), edits))


@FUZZ
@given(edits=EDITS, name=st.sampled_from(["bay", "barrier", "table"]))
def test_included_models(package, edits, name):
    file = package.parents[1] / "models" / name / "model.sdf"
    survives_with(package, file, edits)


@FUZZ
@given(edits=EDITS, name=st.sampled_from(["bay/meshes/curb.stl", "barrier/meshes/barrier.dae"]))
def test_meshes(package, edits, name):
    file = package.parents[1] / "models" / name
    survives_with(package, file, edits)


@FUZZ
@given(edits=EDITS)
def test_actors(tmp_path_factory, edits):
    survives(load_actors, tmp_path_factory.getbasetemp() / "actors.yaml", mutated(ACTORS, edits))


@FUZZ
@given(edits=EDITS)
def test_sites(tmp_path_factory, edits):
    survives(load_sites, tmp_path_factory.getbasetemp() / "sites.yaml", mutated(SITES, edits))


@FUZZ
@given(edits=EDITS)
def test_floor_plans(tmp_path_factory, edits):
    def use(path):
        plan = load_plan(path)
        assert sdf_text(plan)
        assert sites_text(plan.sites)

    survives(use, tmp_path_factory.getbasetemp() / "plan.yaml", mutated(PLAN, edits))


@FUZZ
@given(edits=EDITS, image_edits=EDITS, image=st.sampled_from([PGM, PLAIN_PGM]))
def test_maps(tmp_path_factory, edits, image_edits, image):
    folder = tmp_path_factory.getbasetemp()
    (folder / "m.pgm").write_bytes(mutated(image, image_edits))

    def use(path):
        grid = load_map(path)
        if grid.cells.size < 10_000:
            save_map(grid.upright(), folder / "again.yaml")
            assert np.array_equal(
                grid.upright().cells.shape, load_map(folder / "again.yaml").cells.shape
            )

    survives(use, folder / "m.yaml", mutated(MAP, edits))


def test_models_nested_without_end(tmp_path):
    depth = 3000
    for body in ("{}", "<state world_name='w'>{}</state>"):
        nested = "<model name='m'>" * depth + "</model>" * depth
        text = f"<sdf version='1.7'><world name='w'>{body.format(nested)}</world></sdf>"
        (tmp_path / "w.sdf").write_text(text)
        with pytest.raises(SwarmError, match="nested more than"):
            load_world(tmp_path / "w.sdf")


@pytest.mark.parametrize(
    "text", ["a: " + "[" * 5000, "a: 2001-99-99\n", "? [1, 2]\n: 3\n", "a: " + "9" * 400 + "\n"]
)
def test_yaml_that_breaks_its_reader(tmp_path, text):
    path = tmp_path / "s.yaml"
    path.write_text(text)
    with pytest.raises(SwarmError):
        load_sites(path)

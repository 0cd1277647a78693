"""Reading of zones and filter masks, against masks whose meaning was worked out by hand."""

import numpy as np
import pytest

from swarm_common.files.sites_io import load_sites
from swarm_common.files.zones_io import copy_masks
from swarm_common.model.errors import ConfigError, SwarmError
from swarm_common.model.grid import KEEPOUT, Grid
from swarm_common.model.zones import NO_ZONES, KeepoutZone, SpeedZone, geometry_of

SQUARE = "[[0, 0], [1, 0], [1, 1], [0, 1]]"
GREYS = (255, 254, 230, 204, 128, 100, 26, 0)  # of a mask, from left to right
MAP = Grid(np.zeros((3, 12), np.int8), 0.5, 0.0, 0.0)


def zones_of(folder, text, rest=""):
    path = folder / "sites.yaml"
    path.write_text(f"{rest}\nzones: {text}\n")
    return load_sites(path).zones


def write_mask(folder, name, *lines, greys=GREYS):
    """Write a mask of one row, half a metre a pixel, from (1, 0.5) on."""
    (folder / f"{name}.pgm").write_bytes(f"P5 {len(greys)} 1 255\n".encode() + bytes(greys))
    usual = {
        "image": f"{name}.pgm", "resolution": "0.5", "origin": "[1.0, 0.5, 0.0]",
        "negate": "0", "occupied_thresh": "1.0", "free_thresh": "0.0", "mode": "scale",
    }  # fmt: skip
    usual |= dict(line.split(": ", 1) for line in lines)
    (folder / f"{name}.yaml").write_text("".join(f"{k}: {v}\n" for k, v in usual.items()))


def limits(zones, max_speed=0.5):
    return zones.limits(geometry_of(MAP), max_speed)[1].round(3).tolist()


def test_zones_are_read(tmp_path):
    text = f"""
      keepout: [{{name: press, points: {SQUARE}}}]
      speed:
        - {{name: crossing, points: {SQUARE}, limit: 0.1}}
        - {{name: aisle, points: {SQUARE}, percentage: 40}}
    """
    zones = zones_of(tmp_path, text)
    points = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    assert zones.keepout == (KeepoutZone("press", points),)
    assert zones.speed[0] == SpeedZone("crossing", points, 0.1, False)
    assert zones.speed[1] == SpeedZone("aisle", points, 40.0, True)
    assert zones.limit_at(0.5, 0.5, 0.2) == pytest.approx(0.08)
    assert zones.limit_at(0.5, 0.5, 0.5) == pytest.approx(0.1)
    assert zones.limit_at(1.5, 0.5, 0.5) == np.inf
    assert zones_of(tmp_path, "") is NO_ZONES


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{keepout: [{name: a, points: [[0, 0], [1, 1], [1, 0], [0, 1]]}]}", ("Self-inter",)),
        ("{keepout: [{name: a, points: [[0, 0], [1, 1], [2, 2]]}]}", ("no polygon",)),
        (f"{{keepout: [{{name: a, points: {SQUARE}}}, {{name: a, points: {SQUARE}}}]}}", ("'a'",)),
        (f"{{speed: [{{name: a, points: {SQUARE}}}]}}", ("no limit", "percentage")),
        (f"{{speed: [{{name: a, points: {SQUARE}, limit: 1, percentage: 5}}]}}", ("one of",)),
        (f"{{speed: [{{name: a, points: {SQUARE}, limit: 0}}]}}", ("positive", "keepout zone")),
        (f"{{speed: [{{name: a, points: {SQUARE}, percentage: 0.4}}]}}", ("1 to 100",)),
        ("{keepout_mask: none.yaml}", ("none.yaml",)),
    ],
)
def test_what_is_no_zone_is_an_error_that_says_where(tmp_path, text, words):
    with pytest.raises(SwarmError) as error:
        zones_of(tmp_path, text)
    assert all(word in str(error.value) for word in words), error.value


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        ("stations: {dock: [0.5, 0.5, 0]}", ("station 'dock'", "keepout zone 'press'", "move")),
        ("places: [[3, 3, 0], [0.5, 0.5, 0]]", ("place 2", "keepout zone 'press'")),
        ("circuits: {ring: [[-1, 0.5], [3, 0.5], [3, 3]]}", ("circuit 'ring'", "leads through")),
        ("spawn: {x_min: 0.2, y_min: 0.2, x_max: 0.8, y_max: 0.8}", ("spawn", "wholly")),
        ("spawns: {a: {x: 0.5, y: 0.5, radius: 0.3}}", ("spawns.a", "wholly")),
    ],
)
def test_no_place_of_a_world_lies_in_a_keepout_zone(tmp_path, rest, words):
    text = f"{{keepout: [{{name: press, points: {SQUARE}}}]}}"
    with pytest.raises(ConfigError) as error:
        zones_of(tmp_path, text, rest)
    assert all(word in str(error.value) for word in words), error.value
    beside = """
stations: {dock: [1.5, 0.5, 0]}
spawn: {x_min: 0, y_min: 0, x_max: 8, y_max: 8}
circuits: {ring: [[-1, -1], [3, -1], [3, 3], [-1, 3]]}"""
    zones_of(tmp_path, text, beside)


@pytest.mark.parametrize(
    ("lines", "closed"),
    [
        ((), (7,)),  # scale from 0 to 1: black alone is occupied for good
        (("occupied_thresh: 0.65", "free_thresh: 0.196", "mode: trinary"), (6, 7)),
        (("occupied_thresh: 0.55", "free_thresh: 0.196", "mode: trinary"), (5, 6, 7)),
        (("occupied_thresh: 0.65", "free_thresh: 0.196", "mode: trinary", "negate: 1"),
         (0, 1, 2, 3)),
        (("mode: raw",), (5,)),  # the value itself; above 100 is unknown, that is free
        (("type: 0",), (7,)),
    ],
)  # fmt: skip
def test_a_keepout_mask_closes_what_is_occupied_in_it(tmp_path, lines, closed):
    write_mask(tmp_path, "keep", *lines)
    marked = zones_of(tmp_path, "{keepout_mask: keep.yaml}").mark(MAP)
    assert marked.keepout is not None
    rows, columns = np.nonzero(marked.keepout == KEEPOUT)
    assert set(rows) == {1}  # from y = 0.5 on
    assert columns.tolist() == [2 + pixel for pixel in closed]  # from x = 1 on


def test_greys_of_a_keepout_mask_cost_more_but_are_open(tmp_path):
    write_mask(tmp_path, "keep")
    zones = zones_of(tmp_path, "{keepout_mask: keep.yaml}")
    marked = zones.mark(MAP)
    assert marked.keepout[1].tolist() == [0, 0, 0, 0, 10, 20, 50, 61, 90, 100, 0, 0]
    assert zones.keepout_at(4.6, 0.7) == "a keepout zone of the keepout mask"
    assert not zones.keepout_at(4.4, 0.7)
    assert not zones.keepout_at(40.0, 0.7)


@pytest.mark.parametrize(
    ("entry", "lines", "expected"),
    [
        # Nav2's example: the darker, the slower, in percent; black comes to 0, which is no limit
        ("speed.yaml", ("type: 1", "base: 100.0", "multiplier: -1.0"),
         [0.45, 0.4, 0.25, 0.195, 0.05, np.inf]),
        ("{mask: speed.yaml, type: 1, base: 100.0, multiplier: -1.0}", (),
         [0.45, 0.4, 0.25, 0.195, 0.05, np.inf]),
        ("speed.yaml", ("type: 2", "multiplier: 0.01"), [0.1, 0.2, 0.5, 0.61, 0.9, 1.0]),
        ("speed.yaml", (), [0.05, 0.1, 0.25, 0.305, 0.45, 0.5]),  # percent, and a note on it
        ("{mask: speed.yaml, type: 2, base: 0.3}", ("type: 1", "multiplier: -0.005"),
         [0.25, 0.2, 0.05, np.inf, np.inf, np.inf]),  # below 0 is no limit
    ],
)  # fmt: skip
def test_a_speed_mask_means_what_nav2_makes_of_it(tmp_path, entry, lines, expected):
    write_mask(tmp_path, "speed", *lines)
    zones = zones_of(tmp_path, f"{{speed_mask: {entry}}}")
    assert limits(zones) == [np.inf] * 4 + expected + [np.inf] * 2
    at = [zones.limit_at(0.5 * cell + 0.25, 0.75, 0.5) for cell in range(12)]
    assert np.round(at, 3).tolist() == limits(zones)
    assert zones.limit_at(3.25, 0.2, 0.5) == np.inf  # below the mask


def test_what_a_speed_mask_leaves_open_is_said(tmp_path):
    write_mask(tmp_path, "speed", "multiplier: 2.0", "mode: raw", greys=(0, 60, 255, 30))
    notes = zones_of(tmp_path, "{speed_mask: speed.yaml}").notes
    assert len(notes) == 3
    assert "no type" in notes[0]
    assert "value 60 comes to a limit of 120 %" in notes[1]
    assert "1 unknown cells" in notes[2]
    write_mask(tmp_path, "speed", "type: 2")
    assert not zones_of(tmp_path, "{speed_mask: speed.yaml}").notes


@pytest.mark.parametrize(
    ("text", "lines", "word"),
    [
        ("{keepout_mask: mask.yaml}", ("type: 1",), "type is 1"),
        ("{keepout_mask: mask.yaml}", ("base: 100",), "base 100"),
        ("{speed_mask: mask.yaml}", ("type: 0",), "1 (percent) or 2 (m/s)"),
        ("{speed_mask: mask.yaml}", ("type: fast",), "type is 'fast'"),
    ],
)
def test_a_mask_of_another_kind_is_an_error(tmp_path, text, lines, word):
    write_mask(tmp_path, "mask", *lines)
    with pytest.raises(SwarmError, match=word.replace("(", r"\(").replace(")", r"\)")):
        zones_of(tmp_path, text)


def test_masks_of_the_command_line_replace_those_of_the_file(tmp_path):
    write_mask(tmp_path, "old", "type: 2", "multiplier: 0.01")
    write_mask(tmp_path, "new", "type: 2", "multiplier: 0.02")
    path = tmp_path / "sites.yaml"
    path.write_text("zones: {speed_mask: old.yaml}\n")
    masks = {"speed_mask": tmp_path / "new.yaml"}
    assert limits(load_sites(path, masks).zones)[4:6] == [0.2, 0.4]
    assert limits(load_sites(tmp_path / "missing.yaml", masks).zones)[4:6] == [0.2, 0.4]
    with pytest.raises(ConfigError):
        load_sites(tmp_path / "missing.yaml")
    content = copy_masks(path, masks, tmp_path / "copy")
    assert content == {"zones": {"speed_mask": "speed_mask/new.yaml"}}
    (tmp_path / "new.pgm").unlink()
    (tmp_path / "copy" / "sites.yaml").write_text(f"zones: {content['zones']}")
    assert limits(load_sites(tmp_path / "copy" / "sites.yaml").zones)[4:6] == [0.2, 0.4]


def test_lanes_beside_the_zones_are_those_of_the_zones(tmp_path):
    write_mask(tmp_path, "lanes", "type: 0", "base: 0", "multiplier: 1", "mode: raw", greys=(5, 0))
    path = tmp_path / "sites.yaml"
    path.write_text(f"lanes: lanes.yaml\nzones: {{keepout: [{{name: a, points: {SQUARE}}}]}}\n")
    zones = load_sites(path).zones
    assert zones.lanes is not None
    assert [zone.name for zone in zones.keepout] == ["a"]
    content = copy_masks(path, {}, tmp_path / "copy")
    assert "lanes" not in content
    assert content["zones"]["lanes"] == "lanes/lanes.yaml"
    assert "lanes" not in copy_masks(path, {"lanes": None}, tmp_path / "none")["zones"]
    path.write_text("lanes: lanes.yaml\nzones: {lanes: lanes.yaml}\n")
    with pytest.raises(ConfigError, match=r"sites.yaml: lanes: zones names lanes, too"):
        load_sites(path)

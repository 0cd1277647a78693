"""Maps by Nav2's rules, and what is refused."""

import numpy as np
import pytest
from PIL import Image

from swarm_common.files.map_io import load_map, save_map
from swarm_common.model.errors import MapError
from swarm_common.model.grid import Grid

HEAD = "image: m.pgm\nresolution: 0.05\norigin: [1.0, -2.0, 0.0]\n"


def write(folder, text, pixels=None):
    rows = np.array(pixels or [[0, 254, 205]], np.uint8)
    head = f"P5\n# a comment\n{rows.shape[1]} {rows.shape[0]}\n255\n".encode()
    (folder / "m.pgm").write_bytes(head + rows.tobytes())
    path = folder / "m.yaml"
    path.write_text(text)
    return path


def cells(folder, extra, shades):
    return [int(v) for v in load_map(write(folder, HEAD + extra, [shades])).cells[0]]


def test_what_is_saved_is_loaded_and_the_first_row_is_the_top(tmp_path):
    values = np.array([[0, 100, -1], [100, 100, 0]], np.int8)
    save_map(Grid(values, 0.05, -8.97, -5.47), tmp_path / "m.yaml")
    grid = load_map(tmp_path / "m.yaml")
    assert np.array_equal(grid.cells, values)
    assert (grid.resolution, grid.origin_x, grid.origin_y) == (0.05, -8.97, -5.47)
    grid = load_map(write(tmp_path, HEAD, [[0, 254], [254, 254]]))
    assert grid.cells.tolist() == [[0, 0], [100, 0]]
    assert grid.cell_of(1.01, -1.94) == (1, 0)


def test_shades_become_occupancy_by_mode(tmp_path):
    # Occupancy 1 - shade: 89 -> 0.651, 90 -> 0.647, 191 -> 0.251, 192 -> 0.247.
    assert cells(tmp_path, "", [0, 89, 90, 191, 192, 255]) == [100, 100, -1, -1, 0, 0]
    assert cells(tmp_path, "negate: 1\n", [0, 128, 255]) == [0, -1, 100]
    extra = "mode: scale\noccupied_thresh: 0.75\nfree_thresh: 0.25\n"
    assert cells(tmp_path, extra, [0, 102, 128, 153, 255]) == [100, 70, 50, 30, 0]
    assert cells(tmp_path, "mode: raw\nnegate: 1\n", [0, 50, 100, 101, 255]) == [0, 50, 100, -1, -1]


def test_opacity_counts_by_mode(tmp_path):
    pixels = np.array([[[0, 0, 0, 255], [0, 0, 0, 0]]], np.uint8)
    Image.fromarray(pixels, "RGBA").save(tmp_path / "m.png")
    path = write(tmp_path, HEAD.replace("pgm", "png") + "mode: scale\n")
    assert load_map(path).cells.tolist() == [[100, -1]]
    pixels = np.array([[[0, 0, 0, 255], [0, 0, 0, 0], [255, 255, 255, 0]]], np.uint8)
    Image.fromarray(pixels, "RGBA").save(tmp_path / "m.png")
    text = HEAD.replace("pgm", "png")
    # occupancy 1 - alpha / 4 = 0.75; 1; 1 - 3 / 4 = 0.25, which is not below free_thresh
    assert load_map(write(tmp_path, text)).cells.tolist() == [[100, 100, -1]]
    assert load_map(write(tmp_path, text + "mode: raw\n")).cells.tolist() == [[0, 0, -1]]


def test_colours_and_wide_greys_are_those_of_nav2(tmp_path):
    # (26 + 26 + 27) * 257 / 3 is cut to 6767; 6767 / 65535 * 255 = 26.33
    pixels = np.array([[[26, 26, 27], [100, 101, 101], [100, 100, 101]]], np.uint8)
    Image.fromarray(pixels, "RGB").save(tmp_path / "m.png")
    text = HEAD.replace("pgm", "png")
    assert load_map(write(tmp_path, text + "mode: raw\n")).cells.tolist() == [[26, -1, 100]]
    # Occupancy 0.8967: between thresholds that 8 bits could not tell from each other.
    extra = "occupied_thresh: 0.8968\nfree_thresh: 0.5\n"
    assert load_map(write(tmp_path, text + extra)).cells[0, 0] == -1
    assert load_map(write(tmp_path, text + extra.replace("68", "66"))).cells[0, 0] == 100
    Image.fromarray(np.array([[0, 30000, 65535]], np.uint16)).save(tmp_path / "m.png")
    assert load_map(write(tmp_path, HEAD.replace("pgm", "png"))).cells.tolist() == [[100, -1, 0]]
    path = write(tmp_path, HEAD)
    (tmp_path / "m.pgm").write_bytes(b"P2\n2 1\n15\n0 15\n")
    assert load_map(path).cells.tolist() == [[100, 0]]
    (tmp_path / "m.pgm").write_bytes(b"P5\n2 1\n65535\n\x00\x00\xff\xff")
    assert load_map(path).cells.tolist() == [[100, 0]]


@pytest.mark.parametrize("yaw", [0.4, -2.0, 3.1])
def test_a_rotated_origin_is_kept_and_can_be_turned_upright(tmp_path, yaw):
    pixels = np.full((40, 60), 254, int)
    pixels[5:15, 20:50] = 0
    path = write(tmp_path, HEAD.replace("0.0]", f"{yaw}]"), pixels.tolist())
    grid = load_map(path)
    assert (grid.origin_x, grid.origin_y, grid.origin_yaw) == (1.0, -2.0, yaw)
    upright = grid.upright()
    assert upright.origin_yaw == 0.0
    assert (upright.cells == 100).sum() == pytest.approx(300, rel=0.03)
    for row, column in ((30, 30), (30, 10), (5, 5), (39, 59), (0, 0)):
        u, v = (column + 0.5) * 0.05, (row + 0.5) * 0.05
        x = 1.0 + np.cos(yaw) * u - np.sin(yaw) * v
        y = -2.0 + np.sin(yaw) * u + np.cos(yaw) * v
        assert upright.cells[upright.cell_of(x, y)] == grid.cells[row, column]
    save_map(grid, tmp_path / "again.yaml")
    assert load_map(tmp_path / "again.yaml").origin_yaw == yaw
    assert upright.upright() is upright


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD.replace("m.pgm", "other.pgm"), "'other.pgm' is missing"),
        (HEAD.replace("0.05", "0.0"), "resolution is 0.0"),
        (HEAD.replace("0.05", "900"), "resolution 900"),
        (HEAD.replace("1.0,", "1e9,"), "origin (1000000000.0"),
        (HEAD + "mode: fuzzy\n", "mode is 'fuzzy'"),
        (HEAD + "free_thresh: 0.9\n", "free_thresh 0.9"),
        (HEAD + "negate: perhaps\n", "negate is 'perhaps'"),
        (HEAD.replace("0.05", "0_05"), "resolution is '0_05'"),
        ("image: m.pgm\nresolution: [0.05\norigin: 3\n", "line 3"),
        ("image: a\nimage: b\n", "line 2: malformed YAML: key 'image' occurs twice"),
    ],
)
def test_bad_files_are_refused(tmp_path, text, message):
    with pytest.raises(MapError, match=r"m\.yaml") as caught:
        load_map(write(tmp_path, text))
    assert message in str(caught.value)


@pytest.mark.parametrize("data", [b"P5\n9 9\n255\n\x00", b"P5\n2 x\n255\n\x00", b"P5\n2", b"junk"])
def test_damaged_images_are_refused(tmp_path, data):
    path = write(tmp_path, HEAD)
    (tmp_path / "m.pgm").write_bytes(data)
    with pytest.raises(MapError, match=r"m\.pgm"):
        load_map(path)


@pytest.mark.parametrize(
    "extra", ["mode: Trinary\n", "mode: 'SCALE'\n", "negate: Off\n", "negate: '0'\n", "negate: n\n"]
)
def test_values_are_read_as_yaml_cpp_reads_them(tmp_path, extra):
    quoted = "image: m.pgm\nresolution: '0.05'\norigin: ['1.0', -2, '0']\noccupied_thresh: '.65'\n"
    grid = load_map(write(tmp_path, quoted + extra))
    assert (grid.resolution, grid.origin_x, grid.origin_y) == (0.05, 1.0, -2.0)
    assert grid.cells[0, 0] == 100


@pytest.mark.parametrize("word", ["7", "'1'", "0x1", "Y", "yes", "ON", "True"])
def test_truth_is_written_in_many_ways(tmp_path, word):
    assert load_map(write(tmp_path, f"{HEAD}negate: {word}\n")).cells[0, 0] == 0


def test_home_is_known_in_the_path_of_the_map_and_of_its_image(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    write(tmp_path, HEAD.replace("m.pgm", "~/m.pgm"))
    assert load_map("~/m.yaml").cells.shape == (1, 3)

"""Stations of a picture by colour and name, and the preview of the world made of it."""

import numpy as np
import pytest
from PIL import Image, ImageDraw

from swarm_common.files.sites_io import load_sites
from swarm_common.model.errors import ConfigError
from swarm_map.plan_image import PlanScale, load_picture
from tests.unit.swarm_map.test_map_command import run

ORANGE, VIOLET, GREEN = "#ff8000", "#c000ff", "#00ff00"


def draw(folder, marks):
    """Draw 12 m x 8 m with two orange spots, a violet and a green one, and a start."""
    image = Image.new("RGB", (240, 160), "white")
    pen = ImageDraw.Draw(image)
    pen.rectangle((0, 0, 239, 159), outline="black", width=3)
    pen.rectangle((100, 100, 180, 150), fill="#0000ff")
    for x, y, color in ((20, 40, ORANGE), (20, 80, ORANGE), (200, 40, VIOLET), (200, 80, GREEN)):
        pen.ellipse((x, y, x + 8, y + 8), fill=color)
    image.save(folder / "plant.png")
    (folder / "stations.csv").write_text(marks)
    return folder / "plant.png"


def test_colours_name_stations_and_groups_and_the_preview_shows_them(tmp_path, monkeypatch):
    plan = draw(tmp_path, f"color,name\n{ORANGE},loader\n{VIOLET},shipping\n")
    assert run(monkeypatch, "new", plan, "-o", tmp_path) == 0
    sites = load_sites(tmp_path / "plant" / "sites.yaml")
    assert list(sites.stations) == ["loader_1", "loader_2", "shipping", "station_1"]
    assert sites.groups == {"loader": ("loader_1", "loader_2")}
    assert sites.stations["loader_1"].y > sites.stations["loader_2"].y
    preview = np.asarray(Image.open(tmp_path / "plant" / "preview.png"))
    green = (preview == (0, 130, 60)).all(axis=2)
    left = green[:, : green.shape[1] // 2]
    assert left.any()
    assert green[:, green.shape[1] // 2 :].any()


@pytest.mark.parametrize(
    ("marks", "message"),
    [
        ("name,color\n", "expected lines like"),
        ("color,name\nred,x\n", "line 2"),
        ("color,name\n#202020,x\n", "as dark as a wall"),
        (f"color,name\n{ORANGE},x\n#ff8810,y\n", "too much like"),
        (f"color,name\n{ORANGE},x\n{VIOLET},x\n", "occurs twice"),
        ("color,name\n#ffff00,x\n", "no spot is #ffff00"),
    ],
)
def test_a_list_that_makes_no_sense_is_refused(tmp_path, marks, message):
    with pytest.raises(ConfigError, match=message):
        load_picture(draw(tmp_path, marks), PlanScale())

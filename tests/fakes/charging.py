"""The factory hall with charging stations, and a waffle with a small battery, as a user's files."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from swarm_common.files.resources import share_directory

CHARGERS = {
    "charger_1": [8.3, 0.2, 0.0],
    "charger_2": [6.2, 0.2, 0.0],
    "charger_3": [4.1, 0.2, 0.0],
}
# 1 Wh is spent in ten minutes: every robot has to charge on its way through `loading_route`.
BATTERY = {
    "capacity": 1.0, "voltage": 11.1, "idle_power": 5.0, "drive_power": 10.0,
    "charge_power": 90.0, "initial": [0.4, 0.8],
}  # fmt: skip


def hall_with_chargers(
    folder: Path, chargers: Mapping[str, list[float]] | None = None, **more: Any
) -> Path:
    """Write the hall with charging stations; robots start north of them.

    Args:
        folder: For a folder `hall`.
        chargers: Pose of each by name; None for `CHARGERS`.
        more: Keys of sites.yaml in place of the hall's own.

    Returns:
        The world file.
    """
    share, hall = share_directory(), folder / "hall"
    hall.mkdir()
    shutil.copy(share / "worlds" / "slim_blockage" / "world.sdf", hall)
    for suffix, name in (("yaml", "map.yaml"), ("pgm", "slim_blockage.pgm")):
        shutil.copy(share / "maps" / f"slim_blockage.{suffix}", hall / name)
    sites = yaml.safe_load((share / "worlds" / "slim_blockage" / "sites.yaml").read_text())
    places = CHARGERS if chargers is None else dict(chargers)
    sites["stations"] |= places
    sites["charging"] = list(places)
    del sites["zones"]  # lanes of the hall
    sites["spawn"]["y_min"] = 1.8
    (hall / "sites.yaml").write_text(yaml.safe_dump(sites | more))
    return hall / "world.sdf"


def waffle_with_battery(folder: Path, name: str = "electric_waffle", **battery: Any) -> Path:
    """Write a waffle with a battery; return the folder of the model.

    Args:
        folder: For the folder of the model.
        name: Of the model.
        battery: Values in place of `BATTERY`.
    """
    model = folder / name
    own = share_directory("robots") / "robots" / "turtlebot3_waffle"
    model.mkdir()
    data = yaml.safe_load((own / "robot.yaml").read_text())
    data["description"] = str(own / "model.urdf.xacro")
    data["battery"] = BATTERY | battery
    (model / "robot.yaml").write_text(yaml.safe_dump(data))
    return model

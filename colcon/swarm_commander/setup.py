"""All packages of the checkout as one ROS 2 package, for `colcon build`; pip uses pyproject.toml.

What PyPI has (numba, shapely, viser, ...) is not declared: install it with pip for the Python of
ROS 2, see docs/ros.md.
"""

import os
import tomllib
from pathlib import Path

from setuptools import setup

COMPILED = (".py", ".pyc")  # or copied as code
NAME = "swarm_commander"
HERE = Path(__file__).resolve().parent
ROOT = Path("..", "..")  # setuptools takes no absolute paths
os.chdir(HERE)
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
WHEEL = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]


def packages() -> dict[str, str]:
    """Return the folder of each package of Python, and of each folder of data, by dotted name."""
    found = {}
    for top in WHEEL["packages"]:
        for file in sorted((ROOT / top).rglob("__init__.py")):
            found[".".join(file.parent.relative_to(ROOT).parts)] = str(file.parent)
    for source, target in WHEEL["force-include"].items():
        found[target.replace("/", ".")] = str(ROOT / source)
    return found


def program(script: str, target: str) -> str:
    """Return an entry point by the name that `ros2 run` takes."""
    return f"{script.replace('-', '_')} = {target}"


folders = packages()
setup(
    name=NAME,
    version=PROJECT["project"]["version"],
    packages=list(folders),
    package_dir=folders,
    package_data={
        name: [
            str(p.relative_to(folder))
            for p in Path(folder).rglob("*")
            if p.is_file() and p.suffix not in COMPILED
        ]
        for name, folder in folders.items()
        if ".data" in name or name in WHEEL["packages"]
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/swarm.launch.py"]),
    ],
    entry_points={
        "console_scripts": [
            program(script, target)
            for script, target in PROJECT["project"]["scripts"].items()
            if script != "ros2"  # ROS 2 has its own
        ]
    },
    extras_require={"test": ["pytest"]},  # by which colcon knows how to test
    zip_safe=False,
)

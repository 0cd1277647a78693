"""Robots of our own making, each with a trait that descriptions of real robots have."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

PI = math.pi
LIMITS = "max_vel_x: 0.5\nmax_vel_theta: 1.5\nacc_lim_x: 1.0\nacc_lim_theta: 2.0\n"
GAZEBO_DRIVE = (
    '<gazebo><plugin name="drive" filename="{file}">'
    "<left_joint>left_wheel_joint</left_joint><right_joint>right_wheel_joint</right_joint>"
    "</plugin></gazebo>"
)


def box(x: float, y: float, z: float) -> str:
    return f'<box size="{x:.9g} {y:.9g} {z:.9g}"/>'


def cylinder(radius: float, length: float) -> str:
    return f'<cylinder radius="{radius:.9g}" length="{length:.9g}"/>'


def ball(radius: float) -> str:
    return f'<sphere radius="{radius:.9g}"/>'


def inertial(mass: float, inertia: float, xyz: str = "0 0 0") -> str:
    return (
        f'<inertial><origin xyz="{xyz}"/><mass value="{mass:.9g}"/><inertia ixx="{inertia:.9g}" '
        f'ixy="0" ixz="0" iyy="{inertia:.9g}" iyz="0" izz="{inertia:.9g}"/></inertial>'
    )


def link(name: str, shape: str = "", mass: str = "", xyz: str = "0 0 0", rpy: str = "0 0 0") -> str:
    solid = f'<collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{shape}</geometry></collision>'
    return f'<link name="{name}">{mass}{solid if shape else ""}</link>'


def joint(
    name: str,
    parent: str,
    child: str,
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0),
    rpy: str = "0 0 0",
    kind: str = "fixed",
    axis: str = "0 1 0",
) -> str:
    x, y, z = xyz
    turn = f'<axis xyz="{axis}"/>' if kind != "fixed" else ""
    limit = '<limit lower="-0.6" upper="0.6" effort="9" velocity="9"/>'
    limit = limit if kind == "revolute" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{x:.9g} {y:.9g} {z:.9g}" rpy="{rpy}"/>{turn}{limit}</joint>'
    )


def wheel(
    name: str,
    xyz: tuple[float, float, float],
    radius: float = 0.05,
    parent: str = "base_link",
    mass: str = "",
    kind: str = "continuous",
) -> str:
    mass = mass or inertial(0.3, 4e-4)
    body = link(f"{name}_wheel", cylinder(radius, 0.03), mass, rpy=f"{PI / 2} 0 0")
    return body + joint(f"{name}_wheel_joint", parent, f"{name}_wheel", xyz, kind=kind)


def ray_sensor(
    reference: str,
    rays: int = 360,
    far: float = 8.0,
    first: float = -PI,
    last: float = PI,
    pose: str = "",
    layers: int = 1,
) -> str:
    placed = f"<pose>{pose}</pose>" if pose else ""
    return (
        f'<gazebo reference="{reference}"><sensor name="{reference}_rays" type="gpu_lidar">{placed}'
        f"<update_rate>10</update_rate><lidar><scan><horizontal><samples>{rays}</samples>"
        f"<min_angle>{first}</min_angle><max_angle>{last}</max_angle></horizontal>"
        f"<vertical><samples>{layers}</samples></vertical></scan>"
        f"<range><min>0.1</min><max>{far}</max></range></lidar></sensor></gazebo>"
    )


def lidar(
    name: str = "laser",
    xyz: tuple[float, float, float] = (0.1, 0.0, 0.16),
    rpy: str = "0 0 0",
    parent: str = "base_link",
    **scan: object,
) -> str:
    place = link(name) + joint(f"{name}_joint", parent, name, xyz, rpy)
    return place + ray_sensor(name, **scan)  # type: ignore[arg-type]


def robot(name: str, parts: Iterable[str]) -> str:
    return f'<?xml version="1.0"?>\n<robot name="{name}">' + "\n".join(parts) + "</robot>\n"


CHASSIS = link("base_link", box(0.4, 0.26, 0.1), inertial(6.0, 0.08), xyz="0 0 0.1")


def pair(z: float = 0.05, y: float = 0.15, x: float = 0.0, radius: float = 0.05) -> list[str]:
    """Two wheels on an axle; base_link lies on the ground."""
    return [wheel("left", (x, y, z), radius), wheel("right", (x, -y, z), radius)]


def caster(name: str, x: float, y: float = 0.0, below: float = 0.0, radius: float = 0.02) -> str:
    """A ball that reaches `below` [m] under the ground."""
    body = link(name, ball(radius), inertial(0.05, 1e-5))
    return body + joint(f"{name}_joint", "base_link", name, (x, y, radius - below))


@dataclass(frozen=True)
class Own:
    """A description and its robot.yaml."""

    urdf: str
    settings: str = LIMITS
    files: dict[str, str] = field(default_factory=dict)

    def write(self, folder: Path, name: str = "own") -> Path:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.urdf"
        path.write_text(self.urdf, encoding="utf-8")
        (folder / f"{name}.robot.yaml").write_text(self.settings, encoding="utf-8")
        for file, text in self.files.items():
            (folder / file).write_text(text, encoding="utf-8")
        return path


def sprung(below: float, xs: tuple[float, ...] = (-0.15,)) -> Own:
    """A two-wheeled robot with casters on springs, drawn relaxed."""
    casters = [caster(f"caster_{i}", x, below=below) for i, x in enumerate(xs)]
    return Own(robot("sprung", [CHASSIS, *pair(), *casters, lidar()]))


def lifted(height: float) -> Own:
    """Wheels that end above the ground of base_footprint, and casters that are no balls."""
    footprint = link("base_footprint") + joint("base_joint", "base_footprint", "base_link")
    return Own(robot("lifted", [footprint, CHASSIS, *pair(0.05 + height), lidar()]))


def slanting(off: float) -> Own:
    """One wheel higher than the other."""
    wheels = [wheel("left", (0.0, 0.15, 0.05 + off)), wheel("right", (0.0, -0.15, 0.05))]
    named = "wheels: {left: [left_wheel_joint], right: [right_wheel_joint]}\n"
    text = robot("slanting", [CHASSIS, *wheels, caster("caster", -0.15), lidar()])
    return Own(text, LIMITS + named)


TRAITS: dict[str, Callable[[], Own]] = {
    "caster 2 mm low": lambda: sprung(0.002),
    "casters 2 mm low": lambda: sprung(0.002, (0.16, -0.16)),
    "caster 8 mm low": lambda: sprung(0.008),
    "wheels 0.2 mm high": lambda: lifted(0.0002),
    "wheels 4 mm high": lambda: lifted(0.004),
    "wheels 4 mm low": lambda: lifted(-0.004),
    "one wheel 3 mm high": lambda: slanting(0.003),
}

"""Robots at random: sound ones, odd ones, and broken ones."""

import math

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn

from tests.fakes import own_robots as own
from tests.fakes.own_robots import PI, Own

SIZES = st.floats(0.1, 0.8)
OFFS = st.sampled_from((0.0,) * 8 + (1e-4, -2e-4, 0.002, -0.002) * 3 + (0.004, -0.015, 0.03, -0.05))
LEANS = st.sampled_from(
    ("0 0 0", "0 0 1.2", f"{PI} 0 0", f"0 {PI} 0.3", "0.05 0 0") * 3 + ("0.7 0 0",)
)
WHEELS = st.sampled_from(("cylinder",) * 6 + ("ball", "ball", "none"))
PLUGINS = (
    "", "", "", "", "libgazebo_ros_diff_drive.so", "gz-sim-diff-drive-system",
    "libgazebo_ros_planar_move.so", "gz-sim-velocity-control-system", "", "",
    "libgazebo_ros_ackermann_drive.so",
)  # fmt: skip


@st.composite
def robots(draw: DrawFn) -> Own:
    """Return a strategy of descriptions with their settings."""
    length, width, radius = draw(SIZES), draw(SIZES), draw(st.floats(0.02, 0.15))
    level = draw(st.sampled_from((0.0, radius, 0.3)))  # of base_link above the ground
    mass = 10.0 ** draw(st.floats(-1.0, 2.5))
    spread = 10.0 ** draw(st.sampled_from((0.0,) * 12 + (-3.0, 3.0)))
    inertia = spread * mass * (length**2 + width**2) / 12.0
    shift = draw(st.sampled_from((0.0, 0.0, 0.1, -0.1) * 4 + (0.3, -0.45, 0.7))) * length
    parts = [
        own.link(
            "base_link",
            draw(st.sampled_from((own.box(length, width, 0.1), own.cylinder(length / 2, 0.12)))),
            draw(st.sampled_from((own.inertial(mass, inertia, f"{shift:.9g} 0 0"), ""))),
            xyz=f"0 0 {radius + 0.05 - level:.9g}",
        )
    ]
    track, axle = draw(st.floats(0.6, 1.2)) * width, draw(st.floats(-0.3, 0.3)) * length
    pairs = draw(st.sampled_from((1, 1, 1, 2, 2, 3)))
    shape = draw(WHEELS)
    for k in range(pairs):
        x = axle if pairs == 1 else (0.35 - 0.7 * k / (pairs - 1)) * length
        for side, y in (("left", track / 2), ("right", -track / 2)):
            name = side if pairs == 1 else f"{side}_{k}"
            z = radius - level + draw(OFFS)
            body = {"cylinder": own.cylinder(radius, 0.03), "ball": own.ball(radius), "none": ""}
            weight = draw(st.sampled_from((own.inertial(0.3, 4e-4), "", own.inertial(1.0, 1e-3))))
            parts.append(own.link(f"{name}_wheel", body[shape], weight, rpy=f"{PI / 2:.9g} 0 0"))
            kind = draw(st.sampled_from(("continuous",) * 60 + ("fixed", "revolute")))
            axis = draw(st.sampled_from(("0 1 0",) * 50 + ("0 -1 0",) * 10 + ("0 0 1", "1 0 0")))
            parts.append(
                own.joint(f"{name}_wheel_joint", "base_link", f"{name}_wheel", (x, y, z),
                          "0 0 0", kind, axis)
            )  # fmt: skip
    for k in range(draw(st.integers(0, 3))):
        ball = draw(st.floats(0.005, 0.04))
        x = draw(st.floats(-0.5, 0.5)) * length
        place = (x, draw(st.floats(-0.3, 0.3)) * width, ball - level + draw(OFFS))
        parts.append(own.link(f"caster_{k}", own.ball(ball), own.inertial(0.05, 1e-5)))
        parts.append(own.joint(f"caster_{k}_joint", "base_link", f"caster_{k}", place))
    if draw(st.booleans()):
        low = draw(st.sampled_from((-level, -level, -level + 0.003, 0.1)))
        parts.append(own.link("base_footprint"))
        parts.append(
            own.joint("base_footprint_joint", "base_link", "base_footprint", (0.0, 0.0, low))
        )
    for k in range(draw(st.sampled_from((1, 1, 1, 2, 3) * 3 + (0,)))):
        half = draw(st.sampled_from((PI, PI, 2.0) * 3 + (0.1,)))
        height = draw(st.sampled_from((0.25, 0.4, 0.25, 1.5) * 4 + (0.0,))) - level
        parts.append(
            own.lidar(
                f"laser_{k}",
                (draw(st.floats(-0.3, 0.3)) * length, 0.0, height),
                draw(LEANS),
                rays=draw(st.sampled_from((90, 360, 721) * 3 + (1, 5))),
                far=draw(st.sampled_from((0.5, 4.0, 30.0))),
                first=-half,
                last=half,
                layers=draw(st.sampled_from((1,) * 6 + (16,))),
            )
        )
    plugin = draw(st.sampled_from(PLUGINS))
    if plugin:
        parts.append(f'<gazebo><plugin name="drive" filename="{plugin}"/></gazebo>')
    return Own(own.robot("random", parts), draw(SETTINGS))


SETTINGS = st.builds(
    lambda speed, rate, more: (
        f"max_vel_x: {speed:.6g}\nmax_vel_theta: {rate:.6g}\nacc_lim_x: 1.0\nacc_lim_theta: 2.0\n"
        + more
    ),
    st.floats(0.05, 2.0),
    st.floats(0.2, math.pi),
    st.sampled_from(
        (
            "",
            "",
            "",
            "lidar: {x: 0.0, y: 0.0, z: 0.3}\n",
            "inertia: shapes\n",
            "lidar: {frame: laser_0}\n",
            "drive: omni\n",
            "drive: skid\n",
            "lidar: {z: 0.2}\n",
        )
    ),
)

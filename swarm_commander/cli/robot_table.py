"""Output of `swarm-up --describe`: every value of a robot model, and where it is from."""

from __future__ import annotations

import textwrap
from typing import Any

from swarm_describe.robots.loading import account_of

WIDTH = 100  # characters of a line
UNITS = {
    "wheel_radius": "m", "wheel_separation": "m", "wheel_base": "m", "height": "m",
    "footprint": "m", "max_vel_x": "m/s", "max_vel_y": "m/s", "max_vel_theta": "rad/s",
    "acc_lim_x": "m/s²", "acc_lim_y": "m/s²", "acc_lim_theta": "rad/s²", "lidar.x": "m",
    "lidar.y": "m", "lidar.z": "m", "lidar.yaw": "rad", "lidar.angle_min": "rad",
    "lidar.angle_increment": "rad", "lidar.range_min": "m", "lidar.range_max": "m",
    "lidar.rate": "Hz", "lidar.sigma": "m",
}  # fmt: skip


def robot_table(name_or_path: str) -> str:
    """Return a line for each value of a robot model; below, what is missing and what was assumed.

    Raises:
        SwarmError: If there is no such model, or something of it is unusable.
    """
    account = account_of(name_or_path)
    rows = [
        (name, f"{_shown(value)} {UNITS.get(name, '')}".strip(), source)
        for name, value, source in account.rows
    ]
    rows += [(name, "missing", f"{why}; write it into robot.yaml") for name, why in account.missing]
    wide = max(len(name) for name, _, _ in rows)
    values = max((len(value) for _, value, _ in rows if len(value) <= WIDTH // 3), default=0)
    lines = [account.where]
    for name, value, source in rows:
        start = f"  {name:<{wide}}  {value:<{values}}  "
        lines.append(f"{start}{source}")
    for note in account.notes:
        lines += textwrap.wrap(note, WIDTH, initial_indent="  note: ", subsequent_indent="    ")
    return "\n".join(lines)


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"{value:.5g}"
    if isinstance(value, dict):
        return "; ".join(f"{key}: {_shown(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        if value and isinstance(value[0], list | tuple):
            return " ".join(f"({', '.join(map(_shown, item))})" for item in value)
        return ", ".join(map(_shown, value)) or "none"
    return str(value)

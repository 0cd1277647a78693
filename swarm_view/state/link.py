"""Parameters in the address of a page beside its robot: camera, time, dark or light."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_common.model.records import FloatArray

PARAMETERS = ("robot", "camera", "time", "dark")


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """View with which a page opens."""

    robot: str = ""  # that it looks at; empty for none
    camera: FloatArray | None = None  # position and target (2, 3) in map; None for a preset
    # [s] of simulated time; None for the present, or where a recording is
    time: float | None = None
    is_dark: bool = False  # whether it is dark

    def pairs(self) -> list[tuple[str, str]]:
        """Return names and values for an address."""
        camera = "" if self.camera is None else ",".join(f"{x:.3f}" for x in self.camera.ravel())
        time = "" if self.time is None else f"{self.time:.1f}"
        dark = "1" if self.is_dark else ""
        return list(zip(PARAMETERS, (self.robot, camera, time, dark), strict=True))


def place_of(robot: str, camera: str, time: str, dark: str) -> Viewpoint:
    """Return what the parameters of an address say; those that say nothing are left out."""
    numbers = _numbers(camera)
    times = _numbers(time)
    is_view = len(numbers) == 6 and math.dist(numbers[:3], numbers[3:]) > 1e-3
    return Viewpoint(
        robot,
        np.array(numbers).reshape(2, 3) if is_view else None,
        times[0] if len(times) == 1 else None,
        dark == "1",
    )


def _numbers(text: str) -> list[float]:
    try:
        numbers = [float(word) for word in text.split(",")] if text else []
    except ValueError:
        return []
    return numbers if all(abs(number) < 1e6 for number in numbers) else []

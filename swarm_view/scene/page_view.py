"""How one page looks at the scene: its camera, walls, size of the marks, light or dark."""

from __future__ import annotations

from collections import deque
from functools import partial
from typing import Any

import numpy as np

from swarm_common.model.palette import BLACK, RGB, WHITE
from swarm_common.model.records import FloatArray
from swarm_view.scene.chase import Chase
from swarm_view.scene.fleet import DrawnFleet, Sizes, are_alike
from swarm_view.scene.images import DARK, LIGHT, map_image
from swarm_view.scene.scenery import CUT, MAP, MAP_HEIGHT, WHOLE, draw_image
from swarm_view.scene.views import Camera, View, camera_of, eye_of, whole
from swarm_view.scene.viser_compat import look, run_script, set_visible, update_for
from swarm_view.state.decode import Raster

REPEAT = 3.0  # [s] of wall time after which sizes are sent again: a node may have come later
FOV = 1.309  # [rad] of viser's camera, until a page reports its own
MOVED = 0.05  # [m] by which a reader has moved the camera
EYE_TURN = 0.005  # [rad] or [m] by which a robot has moved, for its eye


class PageView:
    """The view of one page.

    Attributes:
        view: Preset that the page keeps to: FOLLOW, EYE, or None where the reader moves freely.
        sizes: [m] of each robot's mark (n,) as seen there.
    """

    def __init__(self, client: Any, fleet: DrawnFleet) -> None:
        self.view: View | None = None
        self.sizes: FloatArray = np.zeros(0)
        self.is_dark = False
        self._size: tuple[float, float] | None = None
        self._client = client
        self.fleet = fleet
        self._chase = Chase(client.camera, partial(look, client))
        self._scales: Sizes | None = None
        self._scaled = (-1, 0.0)  # the fleet's revision, and when
        self._eye: FloatArray | None = None
        self._map: Any = None
        self._raster: Raster | None = None
        self._waiting: View | None = None  # preset that shows the whole hall
        self._fitted: Camera | None = None  # what it came to
        self._told: deque[FloatArray] = deque(maxlen=8)  # positions that are not the reader's
        self._paint(LIGHT.background)

    @property
    def camera(self) -> Camera | None:
        """The camera that the page reports; None before its first report."""
        return None if self._size is None else camera_of(self._client.camera, self._size)

    @property
    def eye(self) -> FloatArray:
        """Where its camera is (3,), in map."""
        return np.asarray(self._client.camera.position, np.float64)

    def resize(self, width: float, height: float) -> None:
        """Set the size of the page [px]."""
        if width >= 1.0 and height >= 1.0:
            self._size = width, height

    def show_map(self, raster: Raster) -> None:
        """Set the map."""
        if self._raster is None:
            self._raster = raster
            self.set_dark(dark=self.is_dark)

    def take(self, view: View) -> None:
        """Choose a preset."""
        self._chase.rest()
        self._eye = None
        if view is View.PLAN:
            return
        is_whole = view in (View.TOP, View.HALL)
        self.view = None if is_whole else view
        self._waiting, self._fitted = (view if is_whole else None), None

    def rest(self) -> None:
        """Look at another robot from now on."""
        self._chase.rest()
        self._eye = None

    def go(self, target: FloatArray, position: FloatArray) -> None:
        """Look from a position (3,) at a target (3,), both in map."""
        self.view = self._waiting = None
        self._chase.expect(target, position)
        self._chase.look(target, position)

    def show_walls(self, *, whole: bool) -> None:
        """Show whole walls, translucent, or walls that are cut low so that robots are seen."""
        set_visible(self._client, WHOLE, visible=whole)
        set_visible(self._client, CUT, visible=not whole)

    def set_dark(self, *, dark: bool) -> None:
        """Switch to dark or light."""
        self.is_dark = dark
        shades = DARK if dark else LIGHT
        client = self._client
        client.gui.configure_theme(
            dark_mode=dark, show_logo=False, show_share_button=False, control_width="medium"
        )
        self._paint(shades.background)
        if self._map is not None:
            self._map.remove()
            self._map = None
        if dark and self._raster is not None:
            image = map_image(self._raster, shades)
            self._map = draw_image(client.scene, MAP, self._raster, image, MAP_HEIGHT)
        self._scaled = (-1, 0.0)

    def _paint(self, color: RGB) -> None:
        shares = [round(value / 255, 4) for value in color]
        run_script(self._client, f"window.swarm.setBackground({shares})")

    def update(self, poses: FloatArray, index: int | None, now: float) -> None:
        """Move the camera to where the chosen view puts it; `now` is wall time.

        `poses` (n, 3) are in map; `index` is the row of the page's robot, None for none.
        """
        self._fit()
        if index is None or index >= len(poses):
            return
        if self.view is View.FOLLOW:
            self._chase.follow(poses[index], now)
        elif self.view is View.EYE:
            pose = poses[index]
            if self._eye is None or np.abs(pose - self._eye).max() > EYE_TURN:
                self._eye = pose.copy()
                self._chase.look(*eye_of(pose, self.fleet.radius))

    def _fit(self) -> None:
        """Show the whole hall if that is wanted, and again when the page has another size."""
        raster, camera, fitted = self._raster, self.camera, self._fitted
        if raster is None or camera is None or self._waiting is None:
            return
        if fitted is not None:
            if np.abs(camera.position - fitted.position).max() > MOVED:
                if all(np.abs(camera.position - told).max() > MOVED for told in self._told):
                    self._waiting = None  # the reader has turned the view
                return
            if (camera.width, camera.height) == (fitted.width, fitted.height):
                return
        fitted = whole(raster, self._waiting, camera.fov or FOV, camera.width, camera.height)
        self._fitted = fitted
        self._told += [camera.position, fitted.position]
        self._chase.expect(fitted.target, fitted.position)
        self._chase.look(fitted.target, fitted.position)

    def scale_marks(self, poses: FloatArray, now: float) -> None:
        """Scale the marks for this page; called a few times a second."""
        camera = self.camera
        if camera is None or len(poses) != len(self.fleet.names) or not len(poses):
            return
        scales = self.fleet.mark_sizes(camera, poses)
        self.sizes = scales.astype(np.float64) * self.fleet.radius
        revision, since = self._scaled
        is_known = revision == self.fleet.revision and now < since + REPEAT
        if is_known and are_alike(scales, self._scales):
            return
        self._scales, self._scaled = scales, (self.fleet.revision, now)
        rim = np.full((len(scales), 3), WHITE if self.is_dark else BLACK, np.uint8)
        fills, rims = self.fleet.marks
        update_for(self._client, fills, batched_scales=scales)
        update_for(self._client, rims, batched_scales=scales, batched_colors=rim)

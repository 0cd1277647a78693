"""The past of a live swarm on one page: robots where they were, in the states that they had."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from swarm_common.model.records import CONTROL_PERIOD, FloatArray, Pose
from swarm_view.scene.fleet import DrawnFleet
from swarm_view.scene.viser_compat import set_visible
from swarm_view.state.history import History
from swarm_view.state.swarm import Swarm

LIVE, ROOT = "/live", "/past"  # nodes below which robots are drawn, those of now and these


class Past:
    """The swarm at an earlier time, shown on one page in place of the present.

    Attributes:
        time: [s] that is shown; None for the present.
    """

    def __init__(self, client: Any, present: Swarm, history: History) -> None:
        self.time: float | None = None
        self.swarm = Swarm()
        self.fleet = DrawnFleet(client.scene, ROOT)
        self.is_playing = False
        self._client = client
        self._present = present
        self._history = history
        self._played_at = 0.0
        self._tick = -1

    def go(self, time: float, now: float) -> bool:
        """Show a time [s]; return whether something is known of it.

        Where nothing is known, the gap is stepped over, or its beginning is shown.
        """
        start, end = self._history.span
        time = min(max(time, start), end)
        if (gap := self._history.gap_at(time)) is not None:
            time = gap[self.time is not None and time > self.time]
        moment = self._history.moment(time)
        if moment is None:
            return False
        if self.time is None:
            set_visible(self._client, LIVE, visible=False)
        self.time, self._played_at = time, now
        tick, names, poses = moment
        if tick != self._tick:
            self._tick = tick
            self._show(list(names), poses.astype(np.float64), now)
        return True

    def leave(self) -> None:
        """Show the present again."""
        if self.time is not None:
            self.time, self._tick, self.is_playing = None, -1, False
            self.fleet.remove()
            self.fleet.names = []
            set_visible(self._client, LIVE, visible=True)

    def play(self, now: float) -> None:
        """Let time go on if it plays; `now` is wall time."""
        if self.time is not None and self.is_playing:
            self.go(self.time + now - self._played_at, now)
            if self.time >= self._history.span[1]:
                self.leave()
        self._played_at = now

    def _show(self, names: list[str], poses: FloatArray, now: float) -> None:
        swarm, present = self.swarm, self._present
        time = self._tick * CONTROL_PERIOD
        swarm.descriptions, swarm.map = present.descriptions, present.map
        swarm.stations, swarm.layout = present.stations, present.layout
        if swarm.names != names or self.fleet.names != names:
            swarm.names = names
            self.fleet.assemble(names, swarm.descriptions)
        states = {name: self._history.state_at(name, time) for name in names}
        swarm.states = {  # of what they said last, place and distance are those of an earlier time
            name: replace(state, pose_map=Pose(*pose), distance_remaining=math.nan)
            for (name, state), pose in zip(states.items(), poses.tolist(), strict=True)
            if state is not None
        }
        swarm.tick = self._tick
        swarm.track.put(poses)
        self.fleet.move(poses)
        self.fleet.color(names, swarm.states)

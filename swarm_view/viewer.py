"""The viewer's loop: messages in, frames out, and no work while no page is open."""

from __future__ import annotations

import asyncio
import signal
import threading
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import psutil

from swarm_common.model.records import FloatArray
from swarm_common.process.messages import KernelsCompiled
from swarm_view.page.page import Page
from swarm_view.page.past import LIVE
from swarm_view.page.playback import Playback
from swarm_view.scene.fleet import DrawnFleet
from swarm_view.scene.scenery import Scenery
from swarm_view.server.server import Server
from swarm_view.state import topics
from swarm_view.state.history import History
from swarm_view.state.link import Viewpoint
from swarm_view.state.live_feed import Feed
from swarm_view.state.operator_link import OperatorLink
from swarm_view.state.swarm import Swarm, history_of

if TYPE_CHECKING:
    from swarm_recording.bag_feed import BagFeed  # mcap is slow to import

ENDED = "The run has ended. This page shows its last moment."
VIEWER_ENDED = "The viewer has ended. This page shows what it showed last."
Hear = Callable[[], Sequence[KernelsCompiled]]
FAREWELL_PAUSE = 0.3  # [s] of wall time for the last words to reach the pages
FRAME_PERIOD = 0.04  # [s] of wall time: 25 frames per second
LOOK_PERIOD = 3.0  # [s] of wall time between two updates of the list of robots
SLOW_PERIOD = 0.25  # [s] of wall time between two looks at what changes slowly
NEAR_PERIOD = 0.25  # [s] of wall time between two searches for robots near a camera
COLOR_PERIOD = 0.2  # [s] of wall time between two looks at the states' colours
HISTORY_PERIOD = 1.0  # [s] between two poses of a robot's way in a recording
CPU_PERIOD = 2.0  # [s] of wall time between two readings of the machine's load
ALWAYS = {topics.TF, topics.VERDICT, topics.MOVERS}


class Notice:
    """The text on pages of a swarm that starts."""

    def __init__(self, hear: Hear | None) -> None:
        """Begin; `hear` returns new messages of the run since the last call."""
        self._hear = hear
        self._compiled: KernelsCompiled | None = None

    def text(self, swarm: Swarm, *, is_paused: bool) -> str:
        """Return the text; empty once the swarm lives, or is paused before its first tick."""
        if self._hear is not None and (messages := self._hear()):
            self._compiled = messages[-1]
        if swarm.tick > 0 or (is_paused and swarm.markers is not None):
            return ""
        if self._compiled is None:
            return "The swarm is starting."
        count = f"{self._compiled.ready} of {self._compiled.known} kernels are compiled"
        return f"The swarm is starting for the first time: {count}."


class Viewer:
    """Shows a feed to any number of pages. Use `run`, then `close`."""

    def __init__(
        self,
        server: Server,
        feed: Feed,
        link: OperatorLink | None,
        recording: BagFeed | None = None,
        hear: Hear | None = None,
    ) -> None:
        """Attach to a server; `link` is None for a recording.

        `recording` is the feed, if it can be played. `hear` returns new messages of the run that
        this viewer is part of, if any.
        """
        self._recording = recording
        self._server = server
        self._feed = feed
        self._link = link
        self._loop = server.viser.get_event_loop()
        self._wake = asyncio.Event()
        self._swarm = Swarm()
        self._scenery = Scenery(server.viser)
        self._fleet = DrawnFleet(server.viser.scene, LIVE)
        self._cpu, self._cpu_due = "", 0.0
        self._playback: Playback | None = None
        self._notice = Notice(hear)
        self._farewell = VIEWER_ENDED if hear is None else ENDED
        self._slow_due = 0.0
        self._pages: dict[int, Page] = {}
        self._is_stopped = False
        self._look_due = self._color_due = self._near_due = 0.0
        self._revision = self._state_revision = -1
        self._has_map = self._has_scene = False
        self._shown: Any = None
        self._history = History()
        if recording is None:
            self._swarm.history = self._history
        else:
            threading.Thread(target=self._read_history, daemon=True).start()
            jump = self._swarm.forget_past
            self._playback = Playback(server.viser.gui, recording, jump, self._post)
        server.on_pages(self._on_open, self._on_close)

    def stop(self) -> None:
        """Make `run` return soon; from any thread."""
        self._post(self._stop)

    def _read_history(self) -> None:
        """Read all of the recording once; on a thread of its own."""
        assert self._recording is not None
        names = [name for name in self._recording.topics() if name.endswith(f"/{topics.STATUS}")]
        wanted = {topics.TF, topics.VERDICT, *names} & self._recording.topics().keys()
        history = history_of(self._recording.scan(wanted), HISTORY_PERIOD)
        self._post(lambda: self._know_history(history))

    def _know_history(self, history: History) -> None:
        self._history = history
        for page in self._pages.values():
            page.history = history

    def _stop(self) -> None:
        self._is_stopped = True
        self._wake.set()

    def run(self) -> None:
        """Draw frame after frame until stopped.

        All of it happens on viser's event loop, whose queues are not made for other threads.
        """
        asyncio.run_coroutine_threadsafe(self._run(), self._loop).result()

    async def _run(self) -> None:
        while not self._is_stopped:
            if not self._pages:
                self._feed.want(set())
                self._wake.clear()
                await self._wake.wait()
                continue
            started = time.monotonic()
            self.frame(started)
            await asyncio.sleep(max(0.001, FRAME_PERIOD - (time.monotonic() - started)))
        for page in self._pages.values():
            page.end(self._farewell)
        if self._pages:
            await asyncio.sleep(FAREWELL_PAUSE)

    def close(self) -> None:
        """Release everything."""
        self._server.stop()
        self._feed.close()

    def frame(self, now: float) -> None:
        """Process the messages that have arrived and draw one frame; `now` is wall time."""
        swarm = self._swarm
        if now >= self._look_due:
            self._look_due = now + LOOK_PERIOD
            swarm.meet(topics.robots_in(self._feed.topics()))
        wanted = self._wanted()
        swarm.drop_layers(wanted)
        self._feed.want(wanted)
        swarm.apply(self._feed.take(), now)
        if self._link is not None:
            self._link.turn(now)
        self._draw_still()
        poses = swarm.track.at(now)
        with self._server.viser.atomic():
            is_other = self._look_near(poses, now)
            if is_other or self._shown is None or not np.array_equal(poses, self._shown):
                self._shown = poses
                self._fleet.move(poses)
            self._scenery.draw_movers(swarm.movers)
            self._color(now)
        if now >= self._slow_due:
            self._slow_due = now + SLOW_PERIOD
            self._turn_slowly()
        # A recording shows the run, not the load of the machine that plays it.
        if self._playback is None and now >= self._cpu_due:
            self._cpu_due = now + CPU_PERIOD
            cores = psutil.cpu_count()
            self._cpu = f"{psutil.cpu_percent():.0f} % of this machine's {cores} cores"
        for page in self._pages.values():
            page.update(poses, now, self._cpu)

    def _turn_slowly(self) -> None:
        if self._playback is not None:
            self._playback.update()
            return
        is_paused = bool(self._link and self._link.is_paused)
        text = self._notice.text(self._swarm, is_paused=is_paused)
        for page in self._pages.values():
            page.notice(text)

    def _wanted(self) -> set[str]:
        swarm = self._swarm
        wanted = set(ALWAYS)
        wanted |= {f"/{name}/{topics.STATUS}" for name in swarm.names}
        missing = [name for name in swarm.names if name not in swarm.descriptions]
        wanted |= {f"/{name}/{topics.DESCRIPTION}" for name in missing}
        if swarm.map is None:
            wanted.add(topics.MAP)
        if swarm.markers is None:
            wanted.add(topics.SCENE)
        for page in self._pages.values():
            wanted |= page.topics()
        return wanted

    def _draw_still(self) -> None:
        swarm = self._swarm
        if self._revision == swarm.revision:
            return
        self._revision = swarm.revision
        if swarm.map is not None and not self._has_map:
            self._has_map = True
            self._scenery.draw_map(swarm.map)
        if swarm.markers is not None and not self._has_scene:
            self._has_scene = True
            self._scenery.draw_markers(swarm.markers)
        is_complete = all(name in swarm.descriptions for name in swarm.names)
        if is_complete or self._fleet.names != swarm.names:
            self._fleet.assemble(swarm.names, swarm.descriptions)
            self._shown = None
            self._state_revision = -1

    def _look_near(self, poses: FloatArray, now: float) -> bool:
        if now < self._near_due:
            return False
        self._near_due = now + NEAR_PERIOD
        return self._fleet.look_from([page.eye for page in self._pages.values()], poses)

    def _color(self, now: float) -> None:
        if now >= self._color_due and self._state_revision != self._swarm.state_revision:
            self._color_due = now + COLOR_PERIOD
            self._state_revision = self._swarm.state_revision
            self._fleet.color(self._swarm.names, self._swarm.states)

    def _on_open(self, client: Any, place: Viewpoint) -> None:
        self._look_due = 0.0
        if not self._pages and self._recording is None:
            self._history.interrupt()
        self._pages[client.client_id] = Page(
            client, place, self._swarm, self._fleet, self._link, self._server.url, self._post,
            self._history, self._playback,
        )  # fmt: skip
        self._wake.set()

    def _on_close(self, client_id: int) -> None:
        page = self._pages.pop(client_id, None)
        if page is not None:
            page.close()

    def _post(self, call: Callable[[], None]) -> None:
        """Bring a call of another thread to the event loop."""
        self._loop.call_soon_threadsafe(call)


def run_until_signal(viewer: Viewer, announce: Callable[[], None] | None = None) -> None:
    """Run a viewer until SIGINT or SIGTERM, which `announce` may tell users of, and close it."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: viewer.stop())
    if announce is not None:
        announce()
    viewer.run()
    viewer.close()

"""The command `swarm-replay`: a recorded run in the viewer, or on the ROS graph."""

from __future__ import annotations

import contextlib
import functools
import math
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from swarm_common.files.resources import run_folders
from swarm_common.middleware import ros_env
from swarm_common.model.errors import ConfigError
from swarm_common.model.run_words import duration_text, lost_text
from swarm_common.process.signals import SignalCounter
from swarm_recording.bag import Bag
from swarm_recording.filter import CLOCK, PlayOptions, played
from swarm_run.domain import DomainLock, domain_id
from swarm_run.spec import parse_speed
from swarm_setup.build import ensure_interfaces

LONG_GAP = 60.0  # [s] without a message of which the user is told
TELL_PERIOD = 2.0  # [s] of wall time between two lines about the progress

EXAMPLES = """Examples:

swarm-replay

swarm-replay runs/2026-01-31_12-00-00 --start 120 --speed 4

swarm-replay --ros --clock 100 --loop
"""
_viewer = partial(typer.Option, rich_help_panel="In the viewer")
_graph = partial(typer.Option, rich_help_panel="On the ROS graph")

replay_app = typer.Typer(rich_markup_mode="rich")


@replay_app.command(epilog=EXAMPLES)
def replay(
    bag: Annotated[
        Path,
        typer.Argument(metavar="BAG", autocompletion=run_folders, help="File, or folder of a run."),
    ] = Path("runs/latest"),
    info: Annotated[
        bool, typer.Option("--info", help="Only list the topics and messages.")
    ] = False,
    ros: Annotated[
        bool, _graph("--ros", help="Play on the ROS graph, for RViz and any node.")
    ] = False,
    speed: Annotated[
        str, typer.Option(help="Multiple of real time; with --ros also max.", show_default=True)
    ] = "1",
    start: Annotated[
        float | None,
        typer.Option(help="Time in the recording at which to begin, in s.", show_default=False),
    ] = None,
    offset: Annotated[
        float | None,
        _graph(
            help="With --ros: begin so long after the first message, in s, without what was last"
            " said before, but for what stays for latecomers.",
            show_default=False,
        ),
    ] = None,
    topics: Annotated[
        str, _graph(help="With --ros: play only these topics, separated by commas.")
    ] = "",
    clock: Annotated[
        float | None,
        _graph(
            help="With --ros: publish the bag's time on /clock, so often per second of wall time,"
            " in place of the recorded one.",
            show_default=False,
        ),
    ] = None,
    loop: Annotated[bool, _graph("--loop", help="With --ros: start again at the end.")] = False,
    port: Annotated[int, _viewer(help="TCP port of the viewer.")] = 8080,
    open_: Annotated[
        bool | None,
        _viewer(
            "--open/--no-open",
            show_default="where there is a display",
            help="Open it in a browser.",
        ),
    ] = None,
) -> None:
    """Play a run, recorded with `swarm-up --record` or not.

    Without --ros it opens in the browser, where it can be paused and moved through.
    """
    factor = parse_speed(speed, in_real_time=False)
    console = Console(markup=False)  # brackets in a name are none
    tell = functools.cache(lambda words: console.print(words, soft_wrap=True))  # once
    recording = Bag(bag, tell)
    begin = recording.start if start is None else start
    if not recording.start - 1e-9 <= begin <= recording.end:
        raise ConfigError(f"--start is {begin} s; the recording goes from {_span(recording)}")
    if info:
        console.print(_contents(recording))
        for line in filter(None, (lost_text(recording.lost), *_gap_lines(recording))):
            console.print(line, soft_wrap=True, highlight=False)
        recording.close()
    elif ros:
        if start is not None and offset is not None:
            raise ConfigError("--start and --offset both say where to begin; give one")
        if offset is not None and offset > recording.end - recording.start:
            raise ConfigError(f"--offset is {offset} s; the recording goes from {_span(recording)}")
        if factor is not None:
            for line in _gap_lines(recording, begin + (offset or 0.0)):
                tell(line)
        _play(recording, _play_options(topics, start, offset, factor, loop, clock), tell, console)
    else:
        asked = {"--loop": loop, "--topics": topics, "--offset": offset, "--clock": clock}
        for option, value in asked.items():
            if value not in (None, False, ""):
                hint = "; in the viewer, Play at the end starts again" if loop else ""
                raise ConfigError(f"{option} needs --ros{hint}")
        _view(bag, begin, factor, port, tell, open_)


def _play_options(
    topics: str,
    start: float | None,
    offset: float | None,
    speed: float | None,
    loop: bool,
    clock: float | None,
) -> PlayOptions:
    names = [name.strip() for name in topics.split(",") if name.strip()]
    return PlayOptions(
        topics=names or None,
        start=start,
        offset=offset or 0.0,
        speed=speed,
        loops=loop,
        clock_rate=clock,
    )


def _contents(bag: Bag) -> Table:
    """Return the topics of a bag as a table."""
    table = Table(title=f"{bag.path}: {_span(bag)}", title_justify="left")
    for name in ("topic", "type", "quality", "messages"):
        table.add_column(name, justify="right" if name == "messages" else "left", overflow="fold")
    for name, topic in sorted(bag.topics.items()):
        quality = "reliable" if topic.is_reliable else "best effort"
        stays = ", stays" if topic.is_latched else ""
        table.add_row(name, topic.type, quality + stays, str(bag.counts[name]))
    return table


def _gap_lines(bag: Bag, begin: float = -math.inf) -> list[str]:
    """Return in words where nothing is played for long after `begin`, and how to skip that."""
    return [
        f"nothing from {a:.1f} to {b:.1f} s, {duration_text(b - a)}:"
        f" --start {b:.3f} begins after it"
        for a, b in bag.gaps(LONG_GAP)
        if b > begin
    ]


def _span(bag: Bag) -> str:
    return f"{bag.start:.1f} to {bag.end:.1f} s"


def _play(bag: Bag, options: PlayOptions, say: Callable[[str], None], console: Console) -> None:
    """Play on the ROS graph of this terminal's domain."""
    ros_env.set_defaults()  # before rclpy is imported
    ensure_interfaces()  # before our messages are imported
    from swarm_recording.player import play_on_graph

    due = [0.0]

    def tell(t: float) -> None:
        if time.monotonic() >= due[0]:
            due[0] = time.monotonic() + TELL_PERIOD
            console.print(f"t = {t:.1f} of {bag.end:.1f} s", highlight=False)

    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        ros_env.use_quick_heartbeats(folder / "profile.xml")
        if CLOCK in played(bag, options):  # two clocks would jump to and fro
            stack.callback(DomainLock(domain_id()).release)
        signals = stack.enter_context(SignalCounter())
        count = play_on_graph(
            bag, options, say=say, tell=tell, is_stopped=lambda: signals.count > 0
        )
    console.print(f"{count} messages played")


def _view(
    bag: Path,
    start: float,
    speed: float | None,
    port: int,
    tell: Callable[[str], None],
    opens: bool | None,
) -> None:
    """Open the viewer on a bag."""
    if speed is None:
        raise ConfigError("--speed max needs --ros; in the viewer give a number like 10")
    ensure_interfaces()  # before our messages are imported
    from swarm_recording.bag_feed import BagFeed
    from swarm_view.view_command import show_recording

    feed = BagFeed(bag, tell=tell)
    feed.seek(start)
    feed.speed = speed
    feed.play()
    show_recording(feed, port, bag, opens=opens)

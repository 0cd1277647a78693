"""Draw the video in docs/ from recorded runs: 20 robots, a crossing, a dead robot, 100 robots.

Usage: python -m tools.video FOLDER [--parts hall ...] [--out docs/swarm.webm]

FOLDER has the runs that `python -m tools.video_runs FOLDER` records. Poses are the true ones of
/sim/tf, states and held space are what the robots said. Needs Debian's package ffmpeg.
"""

from __future__ import annotations

import argparse
import bisect
import itertools
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from shapely import LineString

from swarm_common.model.grid import OCCUPIED, UNKNOWN
from swarm_common.model.palette import HELD, LOOKS, RGB, state_color
from swarm_recording.bag import NANOSECONDS, Bag
from swarm_report.run import RunData
from swarm_view.scene.images import grid_lines
from swarm_view.state import decode

FloatArray = NDArray[np.float64]
SIZE = (1280, 720)
RATE = 20  # frames per second
PANEL = 300  # [px] at the right, for words
FINER = 2  # times larger when drawn
PAPER, INK, FAINT = (250, 250, 248), (28, 28, 28), (105, 105, 105)
WALL, BEYOND, STATION = (70, 74, 80), (222, 224, 226), (120, 120, 120)
GRID_ALPHA = 18  # of the floor's lines, of 255
BODY = 0.24  # [m] radius around a robot
SMALLEST = 5.5  # [px] radius of a robot
TRAIL = 12.0  # [s] of a robot's way behind it
RARE = ("inactive", "dead", "recovering", "driven by hand")  # named where a robot is in it
SILENT = 2.0  # [s] after which a robot that says nothing counts as dead
Box = tuple[float, float, float, float]  # left, bottom, right, top [m] in map


class RecordedRun:
    """Poses, states and held space of a run at any time."""

    def __init__(self, folder: Path, span: tuple[float, float]) -> None:
        """Read what was recorded between two simulated times [s]."""
        self.data = RunData(folder)
        self.names = self.data.robots
        index = {name: number for number, name in enumerate(self.names)}
        bag = Bag(folder)
        times, rows = [], []
        self._states: list[list[tuple[float, str]]] = [[] for _ in self.names]
        self._held: list[list[tuple[float, FloatArray]]] = [[] for _ in self.names]
        before = max(0.0, span[0] - TRAIL - 1.0)
        for topic, stamp, data in bag.messages(after=round(before * NANOSECONDS)):
            robot, _, kind = topic[1:].rpartition("/")
            at = stamp / NANOSECONDS
            if at > span[1] + 1.0:
                break
            if topic == "/sim/tf":
                row = np.full((len(index), 3), np.nan)
                for transform in decode.message(topic, data).transforms:
                    place = transform.transform.translation
                    turn = transform.transform.rotation
                    yaw = 2.0 * np.arctan2(turn.z, turn.w)
                    row[index[transform.child_frame_id.split("/")[0]]] = (place.x, place.y, yaw)
                times.append(at)
                rows.append(row)
            elif kind == "status" and robot in index:
                self._states[index[robot]].append((at, decode.robot_state(data).state))
            elif kind == "beacon" and robot in index:
                self._held[index[robot]].append((at, decode.motion(data).held))
        self._times = np.array(times)
        self._poses = np.array(rows)
        self._poses[..., 2] = np.unwrap(self._poses[..., 2], axis=0)

    def poses(self, at: float) -> FloatArray:
        """Return x, y [m] and yaw (n, 3), between two samples on the line between them."""
        after = int(np.clip(np.searchsorted(self._times, at), 1, len(self._times) - 1))
        first, last = self._times[after - 1], self._times[after]
        part = float(np.clip((at - first) / (last - first), 0.0, 1.0))
        return (1.0 - part) * self._poses[after - 1] + part * self._poses[after]

    def trail(self, at: float) -> FloatArray:
        """Return the positions (k, n, 2) of the latest seconds, up to now."""
        first, last = np.searchsorted(self._times, (at - TRAIL, at))
        return np.concatenate([self._poses[first:last, :, :2], self.poses(at)[None, :, :2]])

    def states(self, at: float) -> list[str]:
        """Return the state that each robot showed last; dead if it fell silent."""
        found = []
        for robot in range(len(self.names)):
            said = latest(self._states[robot], at)
            heard = latest(self._held[robot], at) or said
            is_silent = heard is not None and at - heard[0] > SILENT
            found.append("dead" if is_silent else said[1] if said else "inactive")
        return found

    def held(self, at: float) -> list[FloatArray]:
        """Return the polyline that each robot holds; empty for one that has said nothing."""
        heard = (latest(held, at) for held in self._held)
        return [np.zeros((0, 2)) if said is None else said[1] for said in heard]

    def reached(self, at: float) -> int:
        """Return the goals reached by then."""
        return sum(goal.outcome == "reached" and goal.time <= at for goal in self.data.goals)


def latest(said: Sequence[tuple[float, Any]], at: float) -> tuple[float, Any] | None:
    """Return the last of entries in order of time that is not later than `at`."""
    place = bisect.bisect_right(said, at, key=lambda entry: entry[0])
    return said[place - 1] if place else None


@dataclass(frozen=True, slots=True)
class Shot:
    """A part of the video."""

    run: str  # folder of the recording
    title: str  # above the words
    words: str  # what is to be seen
    length: float  # [s] of video
    span: tuple[float, float]  # simulated time [s] at its begin and end
    # what is in the picture, at equal distances in time; between them it glides
    views: tuple[Box, ...]


HALL = (-8.9, -5.4, 9.9, 9.9)
AISLE = (-8.6, -5.2, 1.2, 3.2)
SHOTS = (
    Shot(
        "hall", "20 robots at work",
        "Six loaders, shipping, and home. Every robot has a navigator of its own and knows only"
        " its sensors, the map, and what others in radio range say. Green: the space that it"
        " has reserved.",
        29.0, (20.0, 252.0), (HALL, HALL, AISLE, AISLE, HALL),
    ),
    Shot(
        "crossing", "A crossing, 24 robots",
        "Four streams meet where two corridors of 1.8 m cross. Local avoidance mostly locks up"
        " here. These robots reserve space and make way for those with priority.",
        18.0, (3.0, 129.0),
        ((-10.6, -10.6, 10.6, 10.6), (-6.5, -6.5, 6.5, 6.5), (-10.6, -10.6, 10.6, 10.6)),
    ),
    Shot(
        "dead", "One dead robot of 10",
        "The navigator of one robot is killed and stays down: it stops where it is, black. The"
        " others see it by LiDAR, plan around it, and go on. Planar drive.",
        20.0, (32.0, 132.0), (HALL, (-8.8, -4.2, 0.2, 5.6), (-8.8, -4.2, 0.2, 5.6), HALL),
    ),
    Shot(
        "hundred", "100 robots",
        "A warehouse of 60 x 40 m with 24 stations: two picks, a dock, home. A hundred"
        " navigator processes on two processors. Planar drive.",
        15.0, (10.0, 198.0),
        ((-28.0, -20.5, 31.0, 20.5), (-8.0, -13.0, 26.0, 13.0), (-28.0, -20.5, 31.0, 20.5)),
    ),
)  # fmt: skip
OPENING_LINES = (
    ("swarm-workbench", 46, INK, "-Bold"),
    ("20 to 100 mobile robots, each with its own navigator process,", 20, FAINT, ""),
    ("ROS 2 Jazzy messages and rigid-body physics, on two processors", 20, FAINT, ""),
    ("Drawn from recordings of four runs, faster than they were", 15, FAINT, ""),
)
OPENING, CLOSING = 3.5, 4.5  # [s]
FIRST, LAST = "opening", "closing"
PARTS = (FIRST, *(shot.run for shot in SHOTS), LAST)


@cache
def font(size: int, weight: str = "") -> ImageFont.FreeTypeFont:
    """Return a font; in pixels of the finished frame."""
    path = Path(mpl.get_data_path()) / "fonts" / "ttf" / f"DejaVuSans{weight}.ttf"
    return ImageFont.truetype(str(path), FINER * size)


class Sheet:
    """A frame in the making: the scene at the left, words at the right."""

    def __init__(self, recording: RecordedRun, view: Box) -> None:
        """Draw the map."""
        self._width, self._height = FINER * (SIZE[0] - PANEL), FINER * SIZE[1]
        self.scale = min(
            self._width / (view[2] - view[0]), self._height / (view[3] - view[1])
        )  # [px/m]
        self._left = 0.5 * (view[0] + view[2]) - 0.5 * self._width / self.scale
        self._top = 0.5 * (view[1] + view[3]) + 0.5 * self._height / self.scale
        self.image = Image.new("RGB", (FINER * SIZE[0], FINER * SIZE[1]), PAPER)
        self._draw_map(recording)
        self.draw = ImageDraw.Draw(self.image, "RGBA")

    def pixels(self, points: FloatArray) -> list[tuple[float, float]]:
        """Return points (n, 2) [m] as pixels."""
        return [((x - self._left) * self.scale, (self._top - y) * self.scale) for x, y in points]

    def _draw_map(self, recording: RecordedRun) -> None:
        grid = recording.data.grid
        assert grid is not None
        shades = np.full((*grid.cells.shape, 3), PAPER, np.uint8)
        shades[grid.cells == UNKNOWN] = BEYOND
        shades[grid.cells == OCCUPIED] = WALL
        per_cell = 1.0 / (grid.resolution * self.scale)
        x = (self._left - grid.origin_x) / grid.resolution
        y = grid.height - (self._top - grid.origin_y) / grid.resolution
        picture = Image.fromarray(np.ascontiguousarray(shades[::-1]))
        placed = picture.transform(
            (self._width, self._height),
            Image.Transform.AFFINE,
            (per_cell, 0.0, x, 0.0, per_cell, y),
            Image.Resampling.NEAREST,
            fillcolor=BEYOND,
        )
        self.image.paste(placed, (0, 0))

    def line(self, points: FloatArray, color: RGB, alpha: int, width: float) -> None:
        """Draw a polyline; width in pixels of this sheet."""
        if len(points) > 1:
            self.draw.line(self.pixels(points), (*color, alpha), max(1, round(width)))

    def area(self, points: FloatArray, color: RGB, alpha: int) -> None:
        """Fill a polygon."""
        self.draw.polygon(self.pixels(points), (*color, alpha))

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: int,
        color: RGB,
        weight: str = "",
        anchor: str = "la",
    ) -> None:
        """Write; in pixels of the finished frame."""
        place = FINER * x, FINER * y
        self.draw.text(place, text, color, font(size, weight), anchor=anchor)

    def finished(self) -> Image.Image:
        """Return the frame."""
        return self.image.reduce(FINER)


def frame(recording: RecordedRun, shot: Shot, part: float, speed: float) -> Image.Image:
    """Return a frame of a shot; `part` is 0 at its begin and 1 at its end."""
    at = shot.span[0] + part * (shot.span[1] - shot.span[0])
    sheet = Sheet(recording, glide(shot.views, part))
    states = recording.states(at)
    _draw_grid(sheet, recording)
    _draw_stations(sheet, recording)
    for line in recording.trail(at).transpose(1, 0, 2):
        sheet.line(line, (120, 150, 180), 70, 0.05 * sheet.scale)
    for held in recording.held(at):
        if len(held) > 1:
            sheet.area(np.array(LineString(held).buffer(BODY, 6).exterior.coords), HELD, 105)
    _draw_robots(sheet, recording.poses(at), states)
    _draw_words(sheet, recording, shot, at, speed, states)
    return sheet.finished()


def glide(views: Sequence[Box], part: float) -> Box:
    """Return the view at a part of a shot: views stay a while, and glide softly."""
    place = part * (len(views) - 1)
    first = min(int(place), len(views) - 2)
    share = float(np.clip(1.6 * (place - first) - 0.3, 0.0, 1.0))
    soft = share * share * (3.0 - 2.0 * share)
    left, bottom, right, top = (
        (1.0 - soft) * a + soft * b for a, b in zip(views[first], views[first + 1], strict=True)
    )
    return left, bottom, right, top


def _draw_grid(sheet: Sheet, recording: RecordedRun) -> None:
    grid = recording.data.grid
    assert grid is not None
    left, low = grid.origin_x, grid.origin_y
    right, high = left + grid.resolution * grid.width, low + grid.resolution * grid.height
    for x in grid_lines(left, right):
        sheet.line(np.array([[x, low], [x, high]]), INK, GRID_ALPHA, 1.5 * FINER)
    for y in grid_lines(low, high):
        sheet.line(np.array([[left, y], [right, y]]), INK, GRID_ALPHA, 1.5 * FINER)


def _draw_stations(sheet: Sheet, recording: RecordedRun) -> None:
    is_near = sheet.scale > 30.0 * FINER
    for name, pose in recording.data.sites.stations.items():
        diamond = np.array(((0.0, 0.3), (0.3, 0.0), (0.0, -0.3), (-0.3, 0.0)))
        corners = sheet.pixels(diamond + np.array((pose.x, pose.y)))
        sheet.draw.polygon(corners, None, (*STATION, 255), 2 * FINER)
        if is_near:
            x, y = corners[0]
            label = name.replace("_", " ")
            sheet.draw.text((x, y - 3 * FINER), label, INK, font(12), anchor="ms")


def _draw_robots(sheet: Sheet, poses: FloatArray, states: Sequence[str]) -> None:
    radius = max(BODY * sheet.scale, SMALLEST * FINER)
    for (x, y, yaw), state in zip(poses, states, strict=True):
        if not np.isfinite(x):
            continue
        ((px, py),) = sheet.pixels(np.array([[x, y]]))
        color = state_color(state)
        box = (px - radius, py - radius, px + radius, py + radius)
        sheet.draw.ellipse(box, (*color, 255), (255, 255, 255, 255), FINER)
        nose = np.array(((0.85, 0.0), (-0.25, 0.5), (-0.25, -0.5))) * radius
        turn = np.array(((np.cos(yaw), -np.sin(yaw)), (-np.sin(yaw), -np.cos(yaw))))
        corners = [(px + a, py + b) for a, b in nose @ turn.T]
        sheet.draw.polygon(corners, (255, 255, 255, 235))


def _draw_words(
    sheet: Sheet, recording: RecordedRun, shot: Shot, at: float, speed: float, states: Sequence[str]
) -> None:
    left = SIZE[0] - PANEL
    sheet.image.paste((255, 255, 255), (FINER * left, 0, FINER * SIZE[0], FINER * SIZE[1]))
    x, y = left + 20, 26
    sheet.text(x, y, shot.title, 21, INK, weight="-Bold")
    y += 42
    for line in _wrapped(shot.words, PANEL - 40, 13):
        sheet.text(x, y, line, 13, FAINT)
        y += 19
    y += 18
    crashes = recording.data.report["breaches"]["collisions"]
    figures = {
        "simulated time": f"{at:.0f} s",
        "played at": f"{speed:.0f} x",
        "goals reached": str(recording.reached(at)),
        "collisions": str(sum(crash["sim_time"] <= at for crash in crashes)),
    }
    for name, value in figures.items():
        sheet.text(x, y, name, 14, FAINT)
        sheet.text(SIZE[0] - 20, y, value, 16, INK, anchor="ra", weight="-Bold")
        y += 27
    y += 16
    counts = Counter(states)
    for state, look in LOOKS.items():
        if state in RARE and not counts[state]:
            continue
        mark = (FINER * x, FINER * (y + 2), FINER * (x + 14), FINER * (y + 16))
        sheet.draw.ellipse(mark, (*look.color, 255))
        sheet.text(x + 24, y, state, 14, INK)
        sheet.text(SIZE[0] - 20, y, str(counts[state]), 14, INK, anchor="ra")
        y += 25


def _wrapped(text: str, width: int, size: int) -> list[str]:
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if font(size).getlength(longer) > FINER * width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def card(lines: Sequence[tuple[str, int, RGB, str]]) -> Image.Image:
    """Return a frame with centred lines of text, size, colour and weight."""
    image = Image.new("RGB", (FINER * SIZE[0], FINER * SIZE[1]), (255, 255, 255))
    draw = ImageDraw.Draw(image)
    height = sum(round(1.7 * size) for _, size, _, _ in lines)
    y = 0.5 * (SIZE[1] - height)
    for words, size, color, weight in lines:
        draw.text((FINER * SIZE[0] / 2, FINER * y), words, color, font(size, weight), anchor="ma")
        y += round(1.7 * size)
    return image.reduce(FINER)


def closing(folder: Path) -> Image.Image:
    """Return the last picture: what the runs reached."""
    lines: list[tuple[str, int, RGB, str]] = [("What these runs reached", 30, INK, "-Bold")]
    for shot in SHOTS:
        report = RunData(folder / shot.run).report
        goals, crashes = report["goals"], report["collisions"]
        total = goals["reached"] + goals["failed"] + goals["pending"]
        text = (
            f"{shot.title}: {goals['reached']} of {total} goals in {report['sim_time']:.0f} s,"
            f" {crashes['robot_robot'] + crashes['robot_world']} collisions"
        )
        lines.append((text, 19, FAINT, ""))
    return card(lines)


def frames(folder: Path, part: str) -> Iterator[Image.Image]:
    """Yield the frames of a part in order."""
    if part in (FIRST, LAST):
        still = card(OPENING_LINES) if part == FIRST else closing(folder)
        yield from itertools.repeat(still, round((OPENING if part == FIRST else CLOSING) * RATE))
        return
    shot = next(shot for shot in SHOTS if shot.run == part)
    recording = RecordedRun(folder / shot.run, shot.span)
    count = round(shot.length * RATE)
    speed = (shot.span[1] - shot.span[0]) / shot.length
    for number in range(count):
        yield frame(recording, shot, number / (count - 1), speed)


def encode(pictures: Iterator[Image.Image], path: Path, quality: int) -> None:
    """Write frames as WebM (VP9)."""
    command = (
        f"ffmpeg -y -loglevel error -f rawvideo -pix_fmt rgb24 -s {SIZE[0]}x{SIZE[1]} -r {RATE}"
        f" -i - -c:v libvpx-vp9 -crf {quality} -b:v 0 -deadline good -cpu-used 5 -row-mt 1"
        " -threads 1 -g 250 -pix_fmt yuv420p"
    )
    with subprocess.Popen([*command.split(), str(path)], stdin=subprocess.PIPE) as process:
        assert process.stdin is not None
        for picture in pictures:
            process.stdin.write(picture.tobytes())
        process.stdin.close()
        if process.wait():
            raise SystemExit("ffmpeg failed")


def join(pieces: Sequence[Path], path: Path) -> None:
    """Put pieces behind each other."""
    listed = pieces[0].with_name("pieces.txt")
    listed.write_text("".join(f"file '{piece.name}'\n" for piece in pieces), encoding="utf-8")
    command = f"ffmpeg -y -loglevel error -f concat -i {listed} -c copy {path}"
    subprocess.run(command.split(), check=True)


def main() -> int:
    """Draw the video, some of its parts, or one frame of a run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, default=Path("docs/swarm.webm"))
    parser.add_argument("--parts", nargs="*", choices=PARTS, default=PARTS, help="drawn anew")
    parser.add_argument("--quality", type=int, default=40, help="VP9's crf: less is better")
    parser.add_argument("--still", nargs=3, metavar=("RUN", "PART", "FILE"))
    options = parser.parse_args()
    if options.still:
        run, part, file = options.still
        shot = next(shot for shot in SHOTS if shot.run == run)
        speed = (shot.span[1] - shot.span[0]) / shot.length
        frame(RecordedRun(options.folder / run, shot.span), shot, float(part), speed).save(file)
        return 0
    pieces = {part: options.folder / f"{part}.webm" for part in PARTS}
    for part in options.parts:
        encode(frames(options.folder, part), pieces[part], options.quality)
    missing = [part for part, piece in pieces.items() if not piece.exists()]
    if not missing:
        join(list(pieces.values()), options.out)
    print(json.dumps({"missing": missing} if missing else {"bytes": options.out.stat().st_size}))
    return 0


if __name__ == "__main__":
    sys.exit(main())

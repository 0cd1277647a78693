"""The runs in a folder: what each was and how it went, as a page with search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from swarm_common.model.errors import SwarmError
from swarm_common.model.run_words import makespan
from swarm_report.document import number
from swarm_report.judgement import judge
from swarm_report.page import escape, page_html
from swarm_report.run import RunData, mission_goals
from swarm_report.run_files import Report, WorldEntry, read_json
from swarm_report.tables import percent

HEAD = (
    "run", "verdict", "robots", "world", "mission", "seed", "goals reached", "collisions",
    "makespan [s]", "goals per minute", "real-time factor",
)  # fmt: skip
SCRIPT = """
document.addEventListener("DOMContentLoaded", () => {
  const search = document.getElementById("search"), count = document.getElementById("count");
  const rows = [...document.querySelectorAll("tbody tr")];
  const show = () => {
    const words = search.value.toLowerCase().split(/\\s+/).filter(Boolean);
    let shown = 0;
    for (const row of rows) {
      const text = row.textContent.toLowerCase();
      const hidden = !words.every((word) => text.includes(word));
      row.classList.toggle("hidden", hidden);
      shown += !hidden;
    }
    count.textContent = `${shown} of ${rows.length} runs`;
  };
  search.addEventListener("input", show);
  show();
  const picked = () => [...document.querySelectorAll("tbody input:checked")];
  const compare = document.getElementById("compare");
  const ready = () => { compare.disabled = picked().length < 2; };
  document.querySelectorAll("tbody input").forEach((box) => box.addEventListener("change", ready));
  ready();
  search.focus();
});
"""


@dataclass(frozen=True, slots=True)
class Entry:
    """A run in the list: its folder, the kind of its verdict, and the cells of its row."""

    folder: Path
    kind: str
    cells: tuple[str, ...]


def run_folders(runs: Path) -> dict[str, Path]:
    """Return the folders of runs below `runs`, by name, the newest first; links are left out."""
    found = [
        folder
        for folder in runs.iterdir()
        if not folder.is_symlink()
        and ((folder / "report.json").is_file() or (folder / "config" / "world.json").is_file())
    ]
    found.sort(key=lambda folder: (folder.stat().st_mtime, folder.name), reverse=True)
    return {folder.name: folder for folder in found}


class RunList:
    """The list; what was read of a run is kept until its report changes."""

    def __init__(self, runs: Path) -> None:
        """Begin with nothing read; `runs` is the folder with the runs."""
        self._runs = runs
        self._known: dict[Path, tuple[int, Entry]] = {}

    def entries(self) -> list[Entry]:
        """Return the runs, the newest first."""
        return [self._entry(folder) for folder in run_folders(self._runs).values()]

    def page(self) -> str:
        """Return the list as a page; its links are `run/NAME` and `compare?run=NAME&run=NAME`."""
        head = "".join(f"<th>{escape(title)}</th>" for title in ("", *HEAD))
        rows = "".join(map(_row, self.entries()))
        body = [
            '<form action="compare"><p><input id="search" type="search" size="40"'
            ' placeholder="Search: world, mission, failed, 20 …"> <span id="count"></span>'
            ' <button id="compare" type="submit">Compare the chosen runs</button></p>',
            f'<div class="scroll"><table><thead><tr>{head}</tr></thead>'
            f"<tbody>{rows}</tbody></table></div></form>",
        ]
        return page_html("Runs", str(self._runs), body, SCRIPT)

    def _entry(self, folder: Path) -> Entry:
        try:
            changed = (folder / "report.json").stat().st_mtime_ns
        except OSError:
            changed = -1  # it still goes on, or was killed
        known = self._known.get(folder)
        if known is not None and known[0] == changed >= 0:
            return known[1]
        entry = _read(folder)
        self._known[folder] = (changed, entry)
        return entry


def _read(folder: Path) -> Entry:
    try:
        report = read_json(folder / "report.json", Report)
        if not report:
            facts = _facts(_config(folder))
            return Entry(folder, "open", (folder.name, "No verdict", *facts, *"––––"))
        verdict = judge(RunData(folder, report))
    except SwarmError:
        return Entry(folder, "open", (folder.name, "unreadable", *"–––––––––"))
    head = verdict.headline.split(":")[0]
    cells = (folder.name, head, *_facts(report), *_figures(report))
    return Entry(folder, verdict.kind, cells)


def _config(folder: Path) -> dict[str, Any]:
    content = read_json(folder / "config" / "world.json", WorldEntry)
    found = {key: content[key] for key in ("world", "seed") if key in content}
    return found | {"swarm_size": len(content.get("robots", ()))} if content else {}


def _facts(report: Mapping[str, Any]) -> list[str]:
    """Return robots, world, mission, seed and the goals reached."""
    world, goals = Path(str(report.get("world") or "–")), report.get("goals", {})
    total = mission_goals(report)
    share = f" ({percent(goals['reached'] / total)})" if total else ""
    return [
        number(report.get("swarm_size")),
        world.parent.name if world.suffix else world.name,
        str(report.get("mission") or "–"),
        str(report.get("seed", "–")),
        f"{goals['reached']}{share}" if goals else "–",
    ]


def _figures(report: Mapping[str, Any]) -> list[str]:
    """Return collisions, makespan, throughput and real-time factor."""
    crashes = [count for count in report["collisions"].values() if count is not None]
    return [
        str(sum(crashes)) if crashes else "–",
        number(makespan(report)),
        number(report.get("throughput_per_minute")),
        number(report.get("real_time_factor")),
    ]


def _row(entry: Entry) -> str:
    name = escape(entry.folder.name)
    link = f'<a href="run/{quote(entry.folder.name, safe="")}">{name}</a>'
    cells = "".join(f"<td>{escape(cell)}</td>" for cell in entry.cells[2:])
    verdict = f'<td class="{escape(entry.kind)}">{escape(entry.cells[1])}</td>'
    box = f'<input type="checkbox" name="run" value="{name}" aria-label="choose {name}">'
    return f"<tr><td>{box}</td><td>{link}</td>{verdict}{cells}</tr>"

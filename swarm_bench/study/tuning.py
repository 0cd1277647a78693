"""Equal effort of tuning: each method gets the same number of tries, on seeds of its own."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec
import yaml
from msgspec import Meta

from swarm_bench.runs.methods import METHODS
from swarm_bench.study.experiments import FIRST_QUICK_SEED
from swarm_bench.study.trials.cell import Cell, Settings, StudyRun, settings_text
from swarm_bench.study.trials.line import StudyLine
from swarm_common.files.convert import read
from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.model.schema import Count

FOLDER, CHOICES, CHOSEN = "tuning", "methods.yaml", "chosen.yaml"
LEAST_GAIN = 0.03  # by which other settings must be better: less is luck, and does not matter
SHARED = {"central-with-fallback": "central-reservation"}  # methods with the settings of another


class Tuning(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings that are tried, and the runs that compare them."""

    tries: Count  # of each method, its defaults included
    seeds: Annotated[list[Annotated[int, Meta(lt=FIRST_QUICK_SEED)]], Meta(min_length=1)]
    cells: list[Cell]
    methods: dict[str, dict[str, list[Any]]]  # values by parameter, or constant of a baseline


def load_tuning(folder: Path) -> Tuning:
    """Return what is tried.

    Raises:
        ConfigError: If it is missing, or something in it is wrong.
    """
    path = folder / FOLDER / CHOICES
    found = read(path, Tuning)
    for method in found.methods:
        if method not in METHODS:
            raise UnknownNameError(f"{path}: method", method, METHODS)
    return msgspec.structs.replace(found, cells=[cell.placed(folder) for cell in found.cells])


def candidates(tuning: Tuning, method: str) -> list[Settings]:
    """Return what is tried of a method: its defaults first, then draws without repetition."""
    values = tuning.methods[method]
    draw = random.Random(f"tuning/{method}")
    found: dict[Settings, None] = {(): None}
    for _ in range(100 * tuning.tries):
        if len(found) == tuning.tries:
            break
        found[tuple((name, draw.choice(values[name])) for name in sorted(values))] = None
    return list(found)


def tuning_runs(tuning: Tuning) -> list[StudyRun]:
    """Return all runs, seed by seed."""
    return [
        StudyRun(FOLDER, cell, method, seed, settings)
        for seed in tuning.seeds
        for cell in tuning.cells
        for method in tuning.methods
        if not cell.methods or method in cell.methods
        for settings in candidates(tuning, method)
    ]


def choose(tuning: Tuning, lines: Sequence[StudyLine]) -> dict[str, Settings]:
    """Return the settings with the most throughput for each method that all runs are known of.

    Each cell counts the same. Settings with more contacts than the defaults are not chosen, nor
    those that are better by less than `LEAST_GAIN`.
    """
    chosen = {}
    for method in tuning.methods:
        scores = {}
        tried = candidates(tuning, method)
        usual = _by_cell(lines, method, ())
        for settings in tried:
            found = _by_cell(lines, method, settings)
            cells = [each for each in tuning.cells if not each.methods or method in each.methods]
            wanted = len(cells) * len(tuning.seeds)
            if sum(len(members) for members in found.values()) < wanted:
                break
            scores[settings] = (
                max(0, _contacts(found) - _contacts(usual)),
                -sum(_mean(found[cell]) / max(_mean(usual[cell]), 1e-9) for cell in usual),
            )
        if len(scores) == len(tried):
            best = min(scores, key=lambda settings: scores[settings])
            is_better = scores[best][1] < scores[()][1] * (1.0 + LEAST_GAIN)
            chosen[method] = best if is_better else ()
    return chosen


def _by_cell(
    lines: Sequence[StudyLine], method: str, settings: Settings
) -> dict[str, list[StudyLine]]:
    found: dict[str, list[StudyLine]] = {}
    for line in lines:
        if line.method == method and line.settings == settings_text(settings):
            found.setdefault(line.cell, []).append(line)
    return found


def _contacts(found: Mapping[str, Sequence[StudyLine]]) -> int:
    return sum(line.contacts for members in found.values() for line in members)


def _mean(lines: Sequence[StudyLine]) -> float:
    return sum(line.per_hour or 0.0 for line in lines) / len(lines)


def load_chosen(folder: Path) -> dict[str, Settings]:
    """Return the settings that were chosen by method; none if nothing was tuned."""
    path = folder / FOLDER / CHOSEN
    if not path.is_file():
        return {}
    found = read(path, dict[str, dict[str, Any]])
    chosen = {method: tuple(sorted(values.items())) for method, values in found.items()}
    return chosen | {name: chosen[other] for name, other in SHARED.items() if other in chosen}


def write_chosen(folder: Path, chosen: Mapping[str, Settings]) -> Path:
    """Write what was chosen; return the file."""
    path = folder / FOLDER / CHOSEN
    text = "# Written by swarm-bench study --tune.\n"
    text += yaml.safe_dump({method: dict(values) for method, values in chosen.items()})
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as cause:
        raise ConfigError(f"cannot write {path}: {cause}") from cause
    return path

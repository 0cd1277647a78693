"""Which files a bag has: those of its metadata.yaml, or of its folder, with a word on the rest."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

from swarm_common.model.errors import ConfigError
from swarm_recording.bag_metadata import METADATA, BagMetadata, read_metadata

SUFFIXES = (".mcap", ".mcap.zstd", ".mcap.zst")
OTHERS = (".db3", ".db3.zstd", ".bag")  # formats that are only told apart
RECORDING = "recording"  # folder of the bag in that of a run
REPLAY = Path("trace", "replay")  # of what every run keeps, see `run_trace`
SHOWN = 5  # names in a message
CONVERT = (
    "convert it: pip install rosbags, then rosbags-convert --src {path} --dst NEW"
    " --dst-storage mcap"
)
Tell = Callable[[str], None]


def bag_files(path: Path, tell: Tell) -> tuple[tuple[Path, ...], BagMetadata]:
    """Return the files of a bag in order, and what its metadata.yaml says of all of them.

    Args:
        path: File, or the folder of a recording or of a run.
        tell: Told of files that are missing, not listed, or have other names.

    Raises:
        ConfigError: If there is no bag, or it is not clear which files it has.
    """
    if path.is_file() and path.name != METADATA:
        _tell_of_siblings(path, tell)
        return (path,), BagMetadata()
    folder = path.parent if path.name == METADATA else path
    if not _present(folder, SUFFIXES) and (folder / RECORDING).is_dir():
        folder = folder / RECORDING
    if not _present(folder, SUFFIXES) and (found := _present(folder / REPLAY, SUFFIXES)):
        return tuple(found), BagMetadata()
    found = _present(folder, SUFFIXES)
    if not found:
        _refuse(path, folder)
    metadata = _metadata(folder, tell)
    if metadata.files:
        return _listed(folder, metadata.files, found, tell), metadata
    stems = {re.sub(r"_?\d*$", "", _stem(file)) for file in found}
    if len(stems) > 1:
        raise ConfigError(
            f"{folder} has no list of its files in {METADATA}, and they are not numbered parts of"
            f" one recording: {_some(found)}; name one of them"
        )
    if len(found) > 1 or not (folder / METADATA).exists():
        tell(
            f"{folder} has no {METADATA} that lists its files; read by their names: {_some(found)}"
        )
    return tuple(found), metadata


def _metadata(folder: Path, tell: Tell) -> BagMetadata:
    """Return the metadata of a folder; empty, with a word, if it is unusable."""
    try:
        return (
            read_metadata(folder / METADATA, tell)
            if (folder / METADATA).exists()
            else (BagMetadata())
        )
    except ConfigError as error:
        tell(f"{error}; the files are found without it")
        return BagMetadata()


def _listed(
    folder: Path, names: Sequence[str], found: Sequence[Path], tell: Tell
) -> tuple[Path, ...]:
    """Return the files that the metadata lists; for missing ones those that it does not list."""
    paths = [_place(folder, name) for name in names]
    missing = [name for name, path in zip(names, paths, strict=True) if path is None]
    present = [path for path in paths if path is not None]
    others = [path for path in found if path not in present]
    where = folder / METADATA
    if missing and others:
        tell(f"{where} lists {_some(missing)}, not there; read in their place: {_some(others)}")
        return (*present, *others)
    if missing:
        tell(f"{where} lists {_some(missing)}, not there; the others are read")
    if others:
        tell(f"{where} does not list {_some(others)}: not read")
    return tuple(present)


def _place(folder: Path, name: str) -> Path | None:
    """Return where a listed file is; lists may have a folder that has been renamed or moved."""
    for path in (folder / name, folder / Path(name).name):
        if path.is_file():
            return path
    return None


def _present(folder: Path, suffixes: Sequence[str]) -> list[Path]:
    """Return the visible files with one of the endings, `x_2` before `x_10`."""
    if not folder.is_dir():
        return []
    files = [
        path
        for path in folder.iterdir()
        if path.name.endswith(tuple(suffixes)) and not path.name.startswith(".") and path.is_file()
    ]
    return sorted(files, key=lambda path: (_numbers(_stem(path)), path.name))


def _numbers(text: str) -> list[tuple[int, str]]:
    parts = re.split(r"(\d+)", text)
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def _stem(path: Path) -> str:
    return path.name.split(".mcap")[0]


def _tell_of_siblings(path: Path, tell: Tell) -> None:
    if not (path.parent / METADATA).is_file():
        return
    names = {Path(name).name for name in _metadata(path.parent, lambda words: None).files}
    if path.name in names and len(names) > 1:
        tell(f"{path} is one of {len(names)} files of a bag; all of them: {path.parent}")


def _refuse(path: Path, folder: Path) -> None:
    """Raise the error for a place without MCAP files."""
    for other in _present(folder, OTHERS):
        raise wrong_format(other, folder)
    hint = " The files that its metadata.yaml lists are not there." * (folder / METADATA).exists()
    raise ConfigError(
        f"{path}: there is no bag; expected an .mcap file, or the folder of a run"
        f" or of a recording.{hint}"
    )


def wrong_format(path: Path, bag: Path) -> ConfigError:
    """Return the error for a bag of SQLite or of ROS 1, which says how to convert it."""
    kind = "a bag of ROS 1" if path.suffix == ".bag" else "a bag of rosbag2's storage sqlite3"
    source = path if path.suffix == ".bag" else bag
    return ConfigError(
        f"{path} is {kind}; MCAP bags are read here. To {CONVERT.format(path=source)}"
    )


def _some(names: Sequence[str | Path]) -> str:
    shown = ", ".join(name.name if isinstance(name, Path) else name for name in names[:SHOWN])
    return shown + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")

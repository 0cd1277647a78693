"""Containers without an engine: a Dockerfile's steps in a clean Debian, a compose file's services.

A root is made by debootstrap and entered by chroot; each service has a network namespace. What an
engine does beyond that (layers, image format, isolation) is not stood in for.
"""

import fnmatch
import json
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SUITES = {"debian:12-slim": "bookworm"}
MIRROR = "http://deb.debian.org/debian"
OURS = ("PIP_", "http_proxy", "https_proxy", "no_proxy", "HTTP_PROXY", "HTTPS_PROXY", "NO_PROXY")
HOST_BUNDLE = Path("/etc/ssl/certs/ca-certificates.crt")  # of this network's own authority
VARIABLE = re.compile(r"\$\{?(\w+)\}?")
COMPOSE_VARIABLE = re.compile(r"\$\{(\w+)(?::([-?])([^}]*))?\}")


@dataclass(frozen=True)
class Step:
    """An instruction with its flags, like `--from=build`."""

    verb: str
    flags: Mapping[str, str]
    text: str


@dataclass
class Image:
    """What the steps of a stage have made."""

    root: Path
    workdir: str = "/"
    user: str = "0"
    env: dict[str, str] = field(default_factory=dict)
    command: list[str] = field(default_factory=list)


def steps_of(dockerfile: str) -> list[Step]:
    """Return the instructions of a Dockerfile."""
    lines = [line for line in dockerfile.splitlines() if not line.lstrip().startswith("#")]
    found = []
    for line in re.sub(r"\\\n", " ", "\n".join(lines)).splitlines():
        words = line.strip().split(maxsplit=1)
        if not words:
            continue
        flags, text = {}, words[1]
        while match := re.match(r"--([a-z]+)=(\S+)\s+", text):
            flags[match[1]] = match[2]
            text = text[match.end() :]
        found.append(Step(words[0].upper(), flags, text))
    return found


class Builder:
    """Does what a Dockerfile says."""

    def __init__(self, context: Path, folder: Path) -> None:
        self._context = context
        self._folder = folder
        self._bases: dict[str, Path] = {}
        self.stages: dict[str, Image] = {}

    def build(self) -> Image:
        """Return the last stage."""
        image = None
        for step in steps_of((self._context / "Dockerfile").read_text(encoding="utf-8")):
            if step.verb == "FROM":
                name, _, label = step.text.partition(" AS ")
                image = Image(self._clean_root(name, label or "last"))
                self.stages[label or "last"] = image
            else:
                assert image is not None, "a step before FROM"
                self._do(image, step)
        assert image is not None
        return image

    def _do(self, image: Image, step: Step) -> None:
        match step.verb:
            case "RUN":
                run(image, ["/bin/sh", "-ec", step.text], with_network=True)
            case "ENV":
                name, _, value = step.text.partition("=")
                known = image.env | {"PATH": image.env.get("PATH", PATH)}
                image.env[name] = VARIABLE.sub(lambda found: known.get(found[1], ""), value)
            case "WORKDIR":
                image.workdir = step.text
                (image.root / step.text.lstrip("/")).mkdir(parents=True, exist_ok=True)
            case "USER":
                image.user = step.text
            case "COPY":
                self._copy(image, step)
            case "CMD":
                image.command = json.loads(step.text)
            case "EXPOSE" | "STOPSIGNAL":
                pass
            case _:
                raise ValueError(f"unknown instruction {step.verb}")

    def _copy(self, image: Image, step: Step) -> None:
        source, target = step.text.split()
        origin = self.stages[step.flags["from"]].root if "from" in step.flags else self._context
        whole = origin / source.lstrip("/")
        place = image.root / target.lstrip("/")
        ignored = [] if "from" in step.flags else ignore_patterns(self._context)
        shutil.copytree(
            whole, place, symlinks=True, dirs_exist_ok=True, ignore=_ignore(whole, ignored)
        )
        owner = step.flags.get("chown", "0:0")
        run(Image(image.root), ["chown", "--recursive", owner, target])

    def _clean_root(self, name: str, label: str) -> Path:
        if name not in self._bases:
            base = self._folder / "base"
            command = ["debootstrap", "--variant=minbase", SUITES[name], str(base), MIRROR]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            self._bases[name] = base
        root = self._folder / label
        subprocess.run(["cp", "--archive", str(self._bases[name]), str(root)], check=True)
        return root


PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"


def command_in(
    image: Image,
    command: Sequence[str],
    *,
    with_network: bool = False,
    volumes: Mapping[str, Path] | None = None,
) -> list[str]:
    """Return the command line that runs a command in a root, with mounts that end with it."""
    root = shlex.quote(str(image.root))
    mounts = [f"mount -t proc proc {root}/proc", f"mount --rbind /dev {root}/dev"]
    for inside, outside in (volumes or {}).items():
        mounts.append(f"mount --bind {shlex.quote(str(outside))} {root}{inside}")
    home = "/root" if image.user == "0" else "/home/swarm"
    env = {"PATH": PATH, "HOME": home, **image.env}
    if with_network:
        (image.root / "etc" / "resolv.conf").write_bytes(Path("/etc/resolv.conf").read_bytes())
        env |= {name: value for name, value in os.environ.items() if name.startswith(OURS)}
        if HOST_BUNDLE.is_file():
            (image.root / "host-bundle.crt").write_bytes(HOST_BUNDLE.read_bytes())
            env["PIP_CERT"] = "/host-bundle.crt"
    inner = f"cd {shlex.quote(image.workdir)} && exec {shlex.join(command)}"
    as_user = f"--userspec={image.user}:{image.user}"
    words = [f"{name}={value}" for name, value in env.items()]
    chroot = shlex.join(["chroot", as_user, str(image.root), "env", "-i", *words, "/bin/sh", "-c"])
    script = " && ".join([*mounts, f"exec {chroot} {shlex.quote(inner)}"])
    return ["unshare", "--mount", "/bin/sh", "-ec", script]


def run(image: Image, command: Sequence[str], *, with_network: bool = False) -> str:
    """Run a command in a root; return its output."""
    line = command_in(image, command, with_network=with_network)
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{shlex.join(command)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def ignore_patterns(context: Path) -> list[str]:
    lines = (context / ".dockerignore").read_text(encoding="utf-8").splitlines()
    return [line.strip() for line in lines if line.strip() and not line.startswith("#")]


def is_ignored(name: str, patterns: Sequence[str]) -> bool:
    """Tell whether a path relative to the context stays out of it."""
    wanted = [pattern.removeprefix("**/") for pattern in patterns if pattern.startswith("**/")]
    leaf = name.rpartition("/")[2]
    return any(fnmatch.fnmatchcase(leaf, pattern) for pattern in wanted) or any(
        fnmatch.fnmatchcase(name, pattern) for pattern in patterns
    )


def _ignore(whole: Path, patterns: Sequence[str]) -> Any:
    def ignore(folder: str, names: list[str]) -> list[str]:
        inside = Path(folder).relative_to(whole)
        return [name for name in names if is_ignored((inside / name).as_posix(), patterns)]

    return ignore


def interpolated(value: Any, environment: Mapping[str, str]) -> Any:
    """Return a part of a compose file with `${NAME:-default}` and `${NAME:?message}` replaced.

    Raises:
        KeyError: With the message of a variable that has to be set.
    """
    if isinstance(value, dict):
        return {key: interpolated(part, environment) for key, part in value.items()}
    if isinstance(value, list):
        return [interpolated(part, environment) for part in value]
    if not isinstance(value, str):
        return value

    def replace(found: re.Match[str]) -> str:
        name, kind, rest = found.groups()
        if environment.get(name):
            return environment[name]
        if kind == "?":
            raise KeyError(rest)
        return rest or ""

    return COMPOSE_VARIABLE.sub(replace, value)

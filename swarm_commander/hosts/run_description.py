"""The run as the world's host describes it to the robots' hosts: robots and all their parameters.

One side owns every fact, so that the two cannot disagree: a robots' host needs no world, no map
file, no fleet and no parameters of its own. Options that its user states nevertheless are compared
with the run description.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from swarm_common.files.params_io import SECTION, Flat, flatten, nest
from swarm_common.model.errors import ConfigError
from swarm_common.model.robot_names import DEFAULT, RobotNames
from swarm_run.params import NODE, ParameterSource

SITES = "sites"  # the one parameter that is a path on the world's host


@dataclass(frozen=True, slots=True)
class RunDescription:
    """Description of a run on several hosts."""

    run: str  # name of the run, different for each
    edition: str  # of the software on the world's host
    # what a robots' host may state as well: world, seed, robot, swarm_size
    facts: Mapping[str, Any]
    # every robot that needs a navigator, and the parameters that are its own
    robots: Mapping[str, Flat]
    common: Flat  # parameters that all share
    sites: str = ""  # text of the sites file; empty without one
    # in a large swarm, the ports of the world's host that each robot announces itself to, see
    # `participants`; else empty
    peers: Mapping[str, Sequence[int]] = field(default_factory=dict)
    # parameter file of the user
    params: ParameterSource = field(default_factory=ParameterSource)
    names: str = DEFAULT  # of all robots by number, see `RobotNames`

    def to_text(self) -> str:
        """Return it as the text of a message."""
        return json.dumps(asdict(self))

    def parameter_file(self, robot: str, sites_path: str) -> dict[str, Any]:
        """Return the parameter file of a robot, with the sites file of this host."""
        flat = {**self.common, **self.robots[robot]}
        if SITES in flat:
            flat[SITES] = sites_path
        return {f"/{robot}/{NODE}": {SECTION: nest(flat)}}

    def check(self, own_edition: str, stated: Mapping[str, Any]) -> None:
        """Compare what a robots' host is and was told with what the world's host says.

        Raises:
            ConfigError: For the first difference.
        """
        if own_edition != self.edition:
            raise ConfigError(
                f"the world's host runs edition {self.edition} of the software, this one"
                f" {own_edition}; install the same on both"
            )
        for name, value in stated.items():
            if value != self.facts[name]:
                raise ConfigError(
                    f"--{name.replace('_', '-')} is {value} here, but {self.facts[name]} on the"
                    " world's host; leave it out, or start both sides with the same"
                )

    def names_of(self, numbers: Sequence[int]) -> tuple[str, ...]:
        """Return the names of robots.

        Raises:
            ConfigError: If one has no navigator, or is not in the run.
        """
        known = RobotNames.parse(self.names)
        names = tuple(map(known.name_of, numbers))
        for name in names:
            if name not in self.robots:
                there = f"{self.facts['swarm_size']} robots, {len(self.robots)} with a navigator"
                raise ConfigError(
                    f"--robots asks for {name}, but the world has {there}; choose among them"
                )
        return names


def compose(
    run: str,
    edition: str,
    facts: Mapping[str, Any],
    trees: Mapping[str, Mapping[str, Any]],
    sites_path: Path | None,
    peers: Mapping[str, Sequence[int]],
    params: ParameterSource,
    names: str = DEFAULT,
) -> RunDescription:
    """Return the description of a run.

    Args:
        sites_path: Sites file, if there is one.
        peers: See `RunDescription`.
        names: Names of all robots by number, see `RobotNames`.
    """
    flats = {robot: flatten(tree[f"/{robot}/{NODE}"][SECTION]) for robot, tree in trees.items()}
    first = next(iter(flats.values()))
    common = {
        name: value
        for name, value in first.items()
        if all(name in flat and flat[name] == value for flat in flats.values())
    }
    robots = {
        robot: {name: value for name, value in flat.items() if name not in common}
        for robot, flat in flats.items()
    }
    sites = sites_path.read_text(encoding="utf-8") if sites_path is not None else ""
    there = replace(params, path=f"{params.path} on the world's host")
    return RunDescription(
        run, edition, dict(facts), robots, common, sites, dict(peers), there, names
    )


def parse(text: str) -> RunDescription:
    """Return the description in a message.

    Raises:
        ConfigError: If it is none.
    """
    try:
        data = json.loads(text)
        return RunDescription(**{**data, "params": ParameterSource(**data["params"])})
    except (ValueError, TypeError, KeyError) as cause:
        raise ConfigError(
            f"the world's host sent something else than a run description ({cause});"
            " install the same edition of the software on both"
        ) from cause

"""Drivers of a robot in the bench: our navigator, a baseline, or the brain of a user."""

from __future__ import annotations

import dataclasses
import functools
import importlib
from typing import Any, Protocol

from swarm_bench.runs.inputs import plugin_module
from swarm_central.team import TeamFactory
from swarm_common.model.central import Coordination
from swarm_common.model.errors import UnknownNameError
from swarm_common.model.grid import Grid
from swarm_common.model.records import Pose, RobotSpec
from swarm_common.model.sites import Sites
from swarm_common.process.plugins import load_plugin
from swarm_nav.behaviour.plugin_brain import make_brain
from swarm_nav.core.config import BrainConfig, NavConfig
from swarm_nav.core.plugins import BRAIN
from swarm_run.loop import Driver


class Method(Protocol):
    """Makes the driver of one robot; the signature of `Navigator`."""

    def __call__(
        self,
        config: NavConfig,
        spec: RobotSpec,
        grid: Grid,
        sites: Sites,
        robot_id: int,
        initial_pose_map: Pose,
    ) -> Driver:
        """Return a driver of a robot that stands at a pose."""


METHODS = {
    "ours": "swarm_nav.behaviour.plugin_brain:make_brain",
    "dwa": "swarm_bench.baselines.dwa:DwaDriver",
    "orca": "swarm_bench.baselines.orca:OrcaDriver",
    "central-mapf": "swarm_bench.baselines.commanded:CommandedDriver",
    "central-reservation": "swarm_bench.runs.methods:make_led",
    "central-with-fallback": "swarm_bench.runs.methods:make_led_or_alone",
}
OF_NAVIGATORS = ("ours", "central-reservation", "central-with-fallback")  # and their plug-ins
TEAMS = {  # the centre of methods that have one
    "central-mapf": "swarm_central.mapf:MapfCentre",
    "central-reservation": "swarm_central.reservation:ReservationCentre",
    "central-with-fallback": "swarm_central.reservation:ReservationCentre",
}


def load_method(name: str) -> Method:
    """Return a method by name.

    Args:
        name: One of `METHODS`, or a brain or `Team` of one's own: `module:Class`, or an entry
            point's name.

    Raises:
        ConfigError: If there is none.
    """
    if name not in METHODS:
        if ":" in name:
            plugin_module(name)
        if hasattr(_load_own(name), "decide"):
            return load_method("central-mapf")
        BRAIN.load(name)
        return functools.partial(_make_own, BrainConfig(plugin=name))
    module, _, attribute = METHODS[name].partition(":")
    method: Method = getattr(importlib.import_module(module), attribute)
    return method


def _load_own(name: str) -> Any:
    """Return the class of a method that is not among `METHODS`; a `Team` decides for all robots."""
    try:
        return load_plugin(BRAIN.group, name, BRAIN.built_in, "method")
    except UnknownNameError as error:
        if ":" in name:
            raise
        known = {*METHODS, *error.known} - {"navigator"}
        raise UnknownNameError("method", name, known) from None


def _make_own(brain: BrainConfig, config: NavConfig, *rest: Any) -> Driver:
    return make_brain(dataclasses.replace(config, brain=brain), *rest)


def make_led(config: NavConfig, *rest: Any) -> Driver:
    """Return our navigator under a centre, with fallback where the parameters say so."""
    traffic = config.traffic
    if traffic.coordination == Coordination.DECENTRAL:
        traffic = dataclasses.replace(traffic, coordination=Coordination.CENTRAL)
    return make_brain(dataclasses.replace(config, traffic=traffic), *rest)


def make_led_or_alone(config: NavConfig, *rest: Any) -> Driver:
    """Return our navigator under a centre; it decides alone while the centre is silent."""
    coordination = Coordination.CENTRAL_WITH_FALLBACK
    traffic = dataclasses.replace(config.traffic, coordination=coordination)
    return make_brain(dataclasses.replace(config, traffic=traffic), *rest)


def load_team(name: str) -> TeamFactory | None:
    """Return what makes the centre of a method; None if each robot decides alone."""
    if name not in METHODS:
        own = _load_own(name)
        return own if hasattr(own, "decide") else None
    if name not in TEAMS:
        return None
    module, _, attribute = TEAMS[name].partition(":")
    factory: TeamFactory = getattr(importlib.import_module(module), attribute)
    return factory

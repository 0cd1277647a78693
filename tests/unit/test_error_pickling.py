"""Every error of ours passes between processes as it is."""

import importlib
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import pytest

from swarm_common.model.errors import ConfigError, UnknownNameError
from swarm_common.process.plugins import PluginFault
from swarm_nav.core.goals import ErrorCode
from swarm_sim.world.request_checks import Reason
from swarm_vda5050.faults import OrderFault
from tests.fakes.own_classes import PACKAGES, classes_in

FOUND = [each for package in PACKAGES for each in classes_in(package)]
ARGUMENTS: dict[str, tuple[Any, ...]] = {  # where it is not the message alone
    "MissingPackageError": (["one", "other"], "here"),
    "NoSwarmError": (7,),
    "OrderRejectedError": (next(iter(OrderFault)), "not this one"),
    "PlanError": (ErrorCode.NO_VALID_PATH, "no way"),
    "PluginError": (next(iter(PluginFault)), "it failed"),
    "RefusedError": (Reason.NO_MODEL, "no such model"),
    "SwarmEndedError": (),
    "UnknownNameError": ("world", "hal_12", ["hall_12", "doorway"], "a file"),
}


def kinds():
    names = ["swarm_common.model.errors.SwarmError"]
    for name in names:
        names += [f"{each.module}.{each.name}" for each in FOUND if name in each.bases]
    return list(dict.fromkeys(names))


def made(kind, arguments):
    error = kind(*arguments)
    error.faults = (ConfigError("one"), UnknownNameError("robot", "cart", ["card"]))
    error.add_note("seen in a test")
    return error


def state(error):
    held = dict(vars(error))
    faults = [state(fault) for fault in held.pop("faults", ())]
    return type(error), str(error), error.args, held, faults


def test_all_errors_are_found():
    names = {name.rpartition(".")[2] for name in kinds()}
    assert names >= {*ARGUMENTS, "GoalTimeoutError", "OffMapError", "ScaleRunError"}


@pytest.mark.parametrize("name", kinds())
def test_an_error_is_the_same_after_pickling(name):
    module, _, short = name.rpartition(".")
    kind = getattr(importlib.import_module(module), short)
    error = made(kind, ARGUMENTS.get(short, ("a message",)))
    assert state(pickle.loads(pickle.dumps(error))) == state(error)


def fail():
    raise UnknownNameError("world", "hal_12", ["hall_12", "doorway"])


def test_a_pool_of_processes_passes_an_error_on():
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        with pytest.raises(UnknownNameError, match="did you mean 'hall_12'") as caught:
            pool.submit(fail).result()
        assert caught.value.known == ["doorway", "hall_12"]
        assert pool.submit(len, "abc").result() == 3

"""Nobody inherits from a compiled class, whose instances Python would refuse to make.

An interpreted subclass of a class that mypyc has compiled can be defined, and passes every test of
the sources; each call of it ends with "interpreted classes cannot inherit from compiled".
"""

import pytest

from swarm_setup import compiled
from tests.fakes.own_classes import PACKAGES, classes_in, full_name, module_of

COMPILED = {module_of(path) for path in compiled.modules()}


def test_names_are_followed_to_their_class():
    navigator = "swarm_nav.behaviour.navigator.Navigator"
    assert full_name("swarm_workbench.steered", "Navigator") == navigator
    costmap = full_name("swarm_nav.behaviour.services", "costmaps.Costmap")
    assert costmap == "swarm_nav.interfaces.Costmap"
    assert full_name("swarm_bench.cli", "swarm_nav.behaviour.navigator.Navigator") == navigator
    assert full_name("swarm_workbench.gym", "PlanError") == "swarm_workbench.gym.PlanError"
    # by way of a module that only imports it
    assert full_name("examples.own_rule", "RankedGoal") == "swarm_nav.interfaces.RankedGoal"
    assert full_name("swarm_nav.interfaces", "PlanError") == "swarm_nav.core.goals.PlanError"


@pytest.mark.parametrize("folder", [*PACKAGES, "examples", "tools", "tests"])
def test_no_interpreted_class_inherits_from_a_compiled_one(folder):
    wrong = [
        f"{each.module}.{each.name} inherits from {base}"
        for each in classes_in(folder)
        for base in each.bases
        if each.module not in COMPILED and base.rpartition(".")[0] in COMPILED
    ]
    assert not wrong

"""--pack: a number of navigators per process, or one that fits the machine."""

import pytest

from swarm_common.model.errors import ConfigError
from swarm_run.packing import parse_pack
from swarm_run.spec import RunSpec


@pytest.mark.parametrize(
    ("text", "robots", "cores", "expected"),
    [
        (None, 100, 2, 1),
        ("7", 100, 2, 7),
        (7, 100, 2, 7),
        ("auto", 20, 2, 1),
        ("auto", 21, 2, 11),
        ("auto", 100, 2, 50),
        ("auto", 90, 16, 1),
        ("auto", 100, 16, 2),
        ("auto", 1000, 16, 63),
        ("auto", 1, 1, 1),
    ],
)
def test_navigators_per_process(text, robots, cores, expected):
    assert parse_pack(text, robots, 90, cores) == expected


@pytest.mark.parametrize("text", ["0", "-1", "1.5", "", "AUTO", "many", 0])
def test_what_is_no_pack_is_refused_in_words(text):
    with pytest.raises(ConfigError, match=r"--pack is '.*'; expected auto or a positive integer"):
        RunSpec(pack=text).check()


def test_a_run_has_as_many_processes_as_its_packs_make():
    assert RunSpec(swarm_size=5, pack=2).processes == 3
    spec = RunSpec(swarm_size=100, pack="auto")
    assert spec.processes == -(-100 // parse_pack("auto", 100, 90))

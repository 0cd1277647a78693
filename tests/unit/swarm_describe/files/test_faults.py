import pytest

from swarm_common.model.errors import RobotModelError
from swarm_describe.files.faults import LISTED, Faults


def test_one_fault_is_raised_as_it_is():
    faults = Faults("a.urdf", RobotModelError)
    faults.tell(["a.urdf: no link"] * 3)
    with pytest.raises(RobotModelError, match=r"^a\.urdf: no link$"):
        faults.check()


def test_a_long_list_is_cut_and_counted():
    faults = Faults("a.urdf", RobotModelError)
    faults.tell(f"a.urdf: joint {i}" for i in range(200_000))
    with pytest.raises(RobotModelError) as caught:
        faults.check()
    lines = str(caught.value).splitlines()
    assert lines[0] == "a.urdf: 200000 things are wrong:"
    assert lines[1] == "  - joint 0"
    assert lines[-1] == f"  - and {200_000 - LISTED} more"
    assert len(lines) == LISTED + 2
    assert len(caught.value.faults) == 200_000

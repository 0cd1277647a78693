import numpy as np

from swarm_common.files.journal import Journal, read_journal
from swarm_sim.ros.trace import Trace


def test_a_line_a_second_with_the_smallest_clearance_since(tmp_path):
    trace = Trace(Journal(tmp_path / "world.jsonl"), ["Srobot1", "Srobot2"])
    for tick in range(21):
        clearance = 0.0123 if tick == 7 else np.inf
        poses = np.array([[0.1 * tick, 0.0, 0.0], [1.0, 2.0, -3.1416]])
        trace.observe(tick, poses, np.array([[clearance, 0.4], [np.inf, np.inf]]))
    head, *lines = read_journal(tmp_path / "world.jsonl")
    assert head == {"robots": ["Srobot1", "Srobot2"], "near_mm": 500}
    assert [line["t"] for line in lines] == [0.0, 1.0, 2.0]
    assert [line["to_robot"] for line in lines] == [[500, 500], [12, 500], [500, 500]]
    assert lines[2]["x"] == [2000, 1000]
    assert lines[2]["yaw"] == [0, -3142]


def test_a_journal_that_is_cut_off_reads_up_to_there_and_a_closed_one_drops(tmp_path):
    path = tmp_path / "a.jsonl"
    journal = Journal(path)
    journal.write(t=1.0)
    journal.write(t=2.0)
    path.write_bytes(path.read_bytes()[:-3])
    assert read_journal(path) == [{"t": 1.0}]
    assert read_journal(tmp_path / "none.jsonl") == []
    journal = Journal(tmp_path / "a.jsonl")
    journal.close()
    journal.write(t=1.0)
    assert read_journal(tmp_path / "a.jsonl") == []

"""Trajectories in a file: what is written is read, also of a writer that was killed."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.files.trajectory_io import TrajectoryWriter, read_trajectory


@given(counts=st.lists(st.integers(0, 4), max_size=5), lost=st.integers(0, 30))
def test_a_file_is_read_up_to_where_it_is_cut(tmp_path_factory, counts, lost):
    path = tmp_path_factory.mktemp("trajectory") / "trajectory.bin"
    writer = TrajectoryWriter(path)
    written = [np.full((count, 3), tick, np.float64) for tick, count in enumerate(counts)]
    for tick, poses in enumerate(written):
        writer.write(tick, poses, absent=[0] if len(poses) else [])
    writer.close()
    writer.write(99, np.zeros((1, 3)))  # dropped
    data = path.read_bytes()
    path.write_bytes(data[: len(data) - min(lost, len(data))])
    ticks, poses = read_trajectory(path)
    assert ticks.tolist() == list(range(len(ticks)))
    if not lost:
        assert len(ticks) == len(counts)
    for tick, row in zip(ticks, poses, strict=True):
        assert np.isnan(row[:1]).all()
        assert (row[1 : counts[tick]] == tick).all()
        assert np.isnan(row[counts[tick] :]).all()

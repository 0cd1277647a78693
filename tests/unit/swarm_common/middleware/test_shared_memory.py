"""Shared memory that processes leave behind."""

import fcntl
import os

from swarm_common.middleware.ros_env import remove_abandoned

LONG_AGO = (1_000.0, 1_000.0)


def put(folder, *names):
    for name in names:
        (folder / name).touch()
        os.utime(folder / name, LONG_AGO)


def names(folder):
    return {path.name for path in folder.iterdir()}


def test_what_no_living_process_has_locked_is_removed(tmp_path):
    """A run with a DDS profile of the user's left ten files in /dev/shm, each time."""
    put(tmp_path, "fastrtps_1b", "fastrtps_1b_el", "fastrtps_port7000", "fastrtps_port7000_sl")
    put(tmp_path, "sem.fastrtps_port7000_mutex", "lttng-ust-wait-6", "fastrtps_without_lock")
    assert remove_abandoned(tmp_path) == 2
    assert names(tmp_path) == {"lttng-ust-wait-6", "fastrtps_without_lock"}
    assert remove_abandoned(tmp_path / "missing") == 0


def test_what_a_process_holds_or_has_just_made_stays(tmp_path):
    files = {"fastrtps_2c", "fastrtps_2c_el", "fastrtps_2c_sl"}
    put(tmp_path, *files)
    with (tmp_path / "fastrtps_2c_sl").open() as file:
        fcntl.flock(file, fcntl.LOCK_SH)
        assert remove_abandoned(tmp_path) == 0
        assert names(tmp_path) == files
    assert remove_abandoned(tmp_path) == 1
    put(tmp_path, "fastrtps_3d")
    (tmp_path / "fastrtps_3d_el").touch()
    assert remove_abandoned(tmp_path) == 0
    assert names(tmp_path) == {"fastrtps_3d", "fastrtps_3d_el"}

"""Where things are kept if the user's own folders cannot be written."""

import os
from pathlib import Path

import pytest

from swarm_common.model.errors import ConfigError
from swarm_common.process import home

NOBODY = 65534
PLACES = ("ROS_LOG_DIR", "MPLCONFIGDIR")


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return the folder for temporary files of a user with an own, empty home folder."""
    for name in (*PLACES, "ROS_HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(name, "")  # so that what a test sets is taken back
        monkeypatch.delenv(name)
    (tmp_path / "home").mkdir()
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    return tmp_path / "tmp"


def test_an_own_home_folder_needs_nothing_and_a_relative_cache_is_ignored(temporary, monkeypatch):
    home.set_defaults(os.environ)
    assert not [name for name in PLACES if name in os.environ]
    assert home.cache_base() == temporary.parent / "home" / ".cache"
    assert not list(temporary.iterdir())
    monkeypatch.setenv("XDG_CACHE_HOME", "cache")
    assert home.cache_base() == temporary.parent / "home" / ".cache"


@pytest.mark.parametrize("variable", [None, "XDG_CACHE_HOME", "ROS_LOG_DIR"])
def test_each_folder_in_it_counts(temporary, monkeypatch, variable):
    """After one `sudo swarm-up` they may belong to root; rclpy then refused to start."""
    for name in (".ros", ".cache", ".config"):
        (temporary.parent / "home" / name).touch()  # not even root can put files into a file
    if variable is not None:
        monkeypatch.setenv(variable, str(temporary.parent / "home" / ".ros" / "log"))
    home.set_defaults(os.environ)
    assert all(Path(os.environ[name]).is_relative_to(temporary) for name in PLACES)
    assert home.cache_base().is_relative_to(temporary)


def test_places_that_the_user_has_chosen_stay(temporary, monkeypatch, tmp_path):
    (temporary.parent / "home" / ".ros").touch()
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "logs"))
    home.set_defaults(os.environ)
    assert os.environ["ROS_LOG_DIR"] == str(tmp_path / "logs")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")
def test_the_home_folder_of_somebody_else_is_not_ours(tmp_path, monkeypatch):
    """As after `sudo -u` without -H: to ask whether its .cache is a folder was an error."""
    foreign = tmp_path / "foreign"
    foreign.mkdir(mode=0o700)
    monkeypatch.setenv("HOME", str(foreign))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("tempfile.tempdir", "/tmp")
    os.setresuid(NOBODY, NOBODY, 0)
    try:
        base = home.cache_base()
    finally:
        os.setresuid(0, 0, 0)
    assert base.parent == Path("/tmp")
    base.rmdir()


def test_without_any_folder_it_is_said_what_to_do(temporary, monkeypatch):
    def none():
        raise FileNotFoundError(2, "No usable temporary directory found in ['/tmp']")

    (temporary.parent / "home" / ".ros").touch()
    monkeypatch.setattr("tempfile.gettempdir", none)
    with pytest.raises(ConfigError, match="set TMPDIR"):
        home.set_defaults(os.environ)

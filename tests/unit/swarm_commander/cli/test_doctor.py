"""What `swarm-doctor` makes of a machine."""

import dataclasses
from pathlib import Path

import pytest

from swarm_commander.cli import main as cli
from swarm_commander.cli.doctor import Facts, Level, examine

FIT = Facts(
    cpus=4, load=0.1, memory=8000.0, files=4096, threads=30_000, receive_buffer=212_992,
    ephemeral=32_768, ports=frozenset({53, 30_000}), rmw="", stale_interfaces=(),
    has_compiler=True, is_compiled=True, cache=Path("cache"),
)  # fmt: skip


def finding(subject, robots=100, domain=0, **changes):
    facts = dataclasses.replace(FIT, **changes)
    (found,) = (f for f in examine(facts, robots, domain) if f.subject == subject)
    return found


def test_packs_need_less_and_large_ones_larger_buffers():
    assert all(f.level is Level.GOOD and not f.advice for f in examine(FIT, 100, 0))
    assert all(f.level is Level.GOOD for f in examine(FIT, 200, 0, pack=10)[3:])
    # What a process of 10 robots was sent each tick did not fit; a tick took half a second.
    (finding,) = (f for f in examine(FIT, 200, 0, pack=50) if f.subject == "UDP buffer")
    assert finding.level is Level.WARNING
    assert "rmem_max=1000000" in finding.advice


@pytest.mark.parametrize(
    ("subject", "changes", "level", "advice"),
    [
        ("CPUs", {"cpus": 1}, Level.WARNING, "slower than real time"),
        ("CPUs", {"load": 3.0}, Level.WARNING, "other programs"),
        ("memory", {"memory": 2000.0}, Level.ERROR, "at most 41 robots"),
        ("open files", {"files": 256}, Level.ERROR, "ulimit -n 4096"),
        ("threads", {"threads": 900}, Level.ERROR, "--pack 10"),
        ("UDP buffer", {"receive_buffer": 65_536}, Level.WARNING, "sysctl"),
        ("UDP ports", {"ports": frozenset({7450})}, Level.WARNING, "ROS_DOMAIN_ID"),
        ("UDP ports", {"domain": 110}, Level.WARNING, "ROS_DOMAIN_ID=100"),
        ("DDS participants", {"robots": 200}, Level.ERROR, "--pack 10"),
        ("/dev/shm", {"own_dds": "ROS_DISCOVERY_SERVER"}, Level.WARNING, "remount,size=226M"),
        ("RMW", {"rmw": "rmw_zenoh_cpp"}, Level.WARNING, "rmw_fastrtps_cpp"),
        ("ROS interfaces", {"stale_interfaces": ("nav2_msgs",)}, Level.WARNING, "swarm-setup"),
        (
            "ROS interfaces",
            {"stale_interfaces": ("nav2_msgs",), "has_compiler": False},
            Level.ERROR,
            "g++",
        ),
        ("navigators", {"is_compiled": False}, Level.WARNING, "swarm-setup"),
        ("compiled kernels", {"cache": None}, Level.WARNING, "NUMBA_CACHE_DIR"),
    ],
)
def test_what_is_in_the_way_is_said_with_what_to_do(subject, changes, level, advice):
    found = finding(subject, **changes)
    assert found.level is level
    assert advice in found.advice


def test_the_command_prints_a_table(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["swarm-doctor", "--swarm-size", "2"])
    with pytest.raises(SystemExit) as end:
        cli.doctor()
    assert end.value.code in (0, 1)
    assert "This machine and 2 robots" in capsys.readouterr().out


@pytest.mark.parametrize("size", ["-3", "1001"])
def test_an_impossible_size_is_refused(monkeypatch, capsys, size):
    monkeypatch.setattr("sys.argv", ["swarm-doctor", "--swarm-size", size])
    with pytest.raises(SystemExit) as end:
        cli.doctor()
    assert end.value.code == 2
    assert size in capsys.readouterr().err

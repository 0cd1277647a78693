"""Malformed inputs over every topic, service, action and parameter of a running swarm of three.

`pytest -m long tests/faults/test_fuzz_live.py` throws 100,000 of them; by hand, with any seed:
`python -m tests.fuzz_live --count 100000 --seed 0`. The fuzzer runs in a process of its own: what
it publishes would reach the swarms of later tests, too.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUSY = 10.0  # [s] of wall time that a tick may take where other tests run beside this one


def fuzz(folder, count, *flags):
    command = (sys.executable, "-m", "tests.fuzz_live", "--count", str(count), "--seed", "0")
    result = subprocess.run(
        (*command, "--keep", str(folder), *flags),
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    figures = json.loads(
        result.stdout[result.stdout.index("{\n") :]
    )  # DDS writes errors there, too
    return figures


def test_nothing_that_is_malformed_ends_a_process(tmp_path):
    assert fuzz(tmp_path, 1000, "--tick-limit", str(BUSY))["targets"] > 100


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_a_hundred_thousand_times(tmp_path):
    fuzz(tmp_path, 100_000)

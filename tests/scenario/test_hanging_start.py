"""A navigator that is stopped at the start is restarted."""

import json
import subprocess
import sys

import pytest

from tests.fakes.hanging import descendants, hang_one

START = 240.0  # [s] of wall time, on a busy machine that compiles the kernels, too


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize("pack", [1, 2])
def test_a_navigator_that_hangs_at_the_start_is_started_anew(tmp_path, pack):
    flags = ("--swarm-size", "4", "--duration", "10", "--speed", "max", "--headless", "--no-report")
    flags += ("--pack", str(pack))
    code = "from swarm_commander.cli.main import swarm_up; swarm_up()"
    swarm = subprocess.Popen(
        (sys.executable, "-c", code, *flags, "--run-dir", str(tmp_path / "run")),
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        hang_one(descendants(swarm.pid), START)
        output, _ = swarm.communicate(timeout=START)
    finally:
        swarm.kill()
    assert swarm.returncode == 0, output
    report = json.loads((tmp_path / "run" / "report.json").read_text(encoding="utf-8"))
    assert "did not become active with the others: it hangs" in output
    assert report["restarts"] == pack
    assert report["sim_time"] == pytest.approx(10.0)
    assert report["late_ticks"] == 0

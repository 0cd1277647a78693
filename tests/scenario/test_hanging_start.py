"""A navigator that is stopped at the start is restarted."""

import pytest

from tests.fakes.hanging import descendants, hang_one

START = 240.0  # [s] of wall time, on a busy machine that compiles the kernels, too


@pytest.mark.long
@pytest.mark.timeout(600)
@pytest.mark.parametrize("pack", [1, 2])
def test_a_navigator_that_hangs_at_the_start_is_started_anew(start, pack):
    flags = ("--swarm-size", "4", "--duration", "10", "--speed", "max", "--headless", "--no-report")
    swarm = start(*flags, "--pack", str(pack))
    hang_one(descendants(swarm.popen.pid), START)
    report = swarm.good_report(START)
    assert "did not become active with the others: it hangs" in swarm.output
    assert report["restarts"] == pack
    assert report["sim_time"] == pytest.approx(10.0)
    assert report["late_ticks"] == 0

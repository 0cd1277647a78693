"""What the log of states says of a robot's waiting."""

from swarm_interfaces.msg import RobotStatus

from swarm_commander.mission.state_log import StateLog
from swarm_common.files.journal import Journal, read_journal


def test_waiting_is_counted_on_after_the_navigator_was_started_again(tmp_path):
    log = StateLog(Journal(tmp_path / "robots.jsonl"))
    for waited in (0.0, 0.5, 2.0, 8.0, 0.3, 1.5, 1.9):
        log.note("Srobot1", RobotStatus(state="driving", wait_time=waited))
    lines = read_journal(tmp_path / "robots.jsonl")
    assert [line["waited"] for line in lines if "waited" in line] == [2.0, 6.0, 1.5]

from dataclasses import dataclass, field

import pytest

from swarm_commander.run.processes.supervisor import Exit, ProcessSpec, Supervisor


@dataclass
class FakeChild:
    pid: int
    returncode: int | None = None
    calls: list[str] = field(default_factory=list)

    def poll(self):
        return self.returncode

    def terminate(self):
        self.calls.append("terminate")

    def kill(self):
        self.calls.append("kill")


class History:
    """A supervisor with three fake processes and a clock that the test turns."""

    def __init__(self):
        self.now = 0.0
        self.children: dict[str, FakeChild] = {}
        self.supervisor = Supervisor(self._spawn, lambda: self.now)
        for name in ("world", "navigators", "mission"):
            self.supervisor.start(ProcessSpec(name, (name,), grace=5.0))

    def _spawn(self, spec):
        self.children[spec.name] = FakeChild(len(self.children) + 1)
        return self.children[spec.name]

    def end(self, name, returncode):
        self.children[name].returncode = returncode
        return self.supervisor.poll()

    def calls(self):
        return {name: child.calls for name, child in self.children.items() if child.calls}


def test_an_end_is_told_once_and_killing_spares_only_the_gone():
    history = History()
    assert history.end("world", -11) == [Exit("world", -11, expected=False)]
    assert history.supervisor.poll() == []
    assert history.calls() == {"world": ["kill"]}
    assert history.supervisor.pid("world") is None
    history = History()
    history.end("mission", 0)
    history.supervisor.kill()
    assert history.calls() == {"world": ["kill"], "navigators": ["kill"], "mission": ["kill"]}
    for name in ("world", "navigators"):
        assert history.end(name, -9) == [Exit(name, -9, expected=True, killed=True)]
    assert history.supervisor.all_gone


def test_processes_are_stopped_one_after_the_other_in_the_given_order():
    history = History()
    history.supervisor.stop(["world", "mission"])
    history.supervisor.poll()
    assert history.calls() == {"world": ["terminate"]}
    assert history.end("world", 0) == [Exit("world", 0, expected=True)]
    assert history.calls()["mission"] == ["terminate"]
    history.end("mission", 0)
    assert history.calls()["navigators"] == ["terminate"]
    history.end("navigators", 0)
    assert history.supervisor.all_gone


def test_a_process_that_does_not_end_is_killed_after_its_grace_also_if_asked_twice():
    history = History()
    history.supervisor.stop(["world"])
    for now in (0.0, 4.9):
        history.now = now
        history.supervisor.poll()
    assert history.calls() == {"world": ["terminate"]}
    history.now = 5.0
    history.supervisor.poll()
    history.supervisor.poll()
    assert history.calls() == {"world": ["terminate", "kill"]}
    assert history.end("world", -9) == [Exit("world", -9, expected=True, killed=True)]
    history = History()
    history.supervisor.stop(["world"])
    history.supervisor.poll()
    history.now = 4.0
    history.supervisor.stop(["world"])
    history.supervisor.poll()
    history.now = 5.0
    history.supervisor.poll()
    assert history.calls() == {"world": ["terminate", "kill"]}


def test_a_process_that_runs_is_not_started_twice_but_one_that_has_ended_is_restarted():
    history = History()
    with pytest.raises(ValueError, match="started before"):
        history.supervisor.start(ProcessSpec("world", ("world",)))
    assert history.supervisor.restarts == 0
    history.end("world", 1)
    history.supervisor.start(ProcessSpec("world", ("world",)))
    assert history.supervisor.restarts == 1
    assert history.supervisor.pid("world") == 4

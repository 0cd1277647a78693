from pathlib import Path

from swarm_nav.states import diagram

ROOT = Path(__file__).parents[2]


def test_the_state_diagram_in_the_architecture_is_the_automaton() -> None:
    assert diagram() in (ROOT / "ARCHITECTURE.md").read_text()


def test_the_architecture_stays_short() -> None:
    assert len((ROOT / "ARCHITECTURE.md").read_text().splitlines()) <= 150

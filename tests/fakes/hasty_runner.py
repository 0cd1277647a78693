"""The mission process, impatient with silent robots: `python -m tests.fakes.hasty_runner`."""

from swarm_commander.mission import runner

if __name__ == "__main__":
    runner.GIVE_UP_TIME = 12.0
    runner.main()

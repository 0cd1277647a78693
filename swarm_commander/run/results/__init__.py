"""Results of a run: numbers while it goes on, the terminal, and the report.

What a module imports of its folder stands above it:

    run_statistics  The state of a run while it goes on: events of the processes added up
    report          `report.json`: the result of a run in the form that tools outside rely on
    status_table    The robots in a few lines: a letter each, one line per group, however large the
                    swarm
    progress        What the user sees while a run goes, and the table at its end

May import of swarm_commander: what `run` may, of `run` itself `processes`;
swarm_mission and swarm_common.
"""

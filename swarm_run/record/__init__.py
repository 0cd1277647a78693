"""The record of a run: `report.json`, the bench's result line and Python's report are views of it.

What a module imports of its folder stands above it:

    figures      Derived figures, each by one function: rates, percentiles, waiting, fairness
    run_record   `RunRecord`: the schema, and the line of a bench
    compose      From what robots, world and mission say at the end of a run to its record
    report_file  `report.json` of a record, and back

May import swarm_common and swarm_mission; neither ROS nor the other parties.
"""

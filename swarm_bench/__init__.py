"""Bench: many seeded runs of the same brains in the same world, in one process without ROS.

What imports nothing of the folders below it stands first:

    statistics  Intervals, pairs and curves
    tables      Tables for the terminal, Markdown and HTML
    baselines   DWA and ORCA, to compare with
    runs        One run of a scenario, up to its result
    execution   Many runs, and their results on disk
    suite       Sweeps over scenarios and seeds
    halls       Random halls
    capacity    Throughput over robots
    lanes       Preferred lanes, learned from where robots lose time
    study       Decentralised against central control
    cli         The command `swarm-bench`

May import swarm_sim, swarm_nav, swarm_mission, and swarm_common; nobody
imports it.
"""

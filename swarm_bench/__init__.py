"""Bench: many seeded runs of the same brains in the same world, in one process without ROS.

What imports nothing of the folders below it stands first:

    baselines  DWA and ORCA, to compare with
    runs       One run of a scenario, up to its result
    suite      Many runs, and their tables
    halls      Random halls
    cli        The command `swarm-bench`

May import swarm_sim, swarm_nav, swarm_mission, and swarm_common; nobody
imports it.
"""

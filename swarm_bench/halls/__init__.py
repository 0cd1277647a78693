"""Random halls with random missions, by seed: `halls`.

What a module imports of its folder stands above it:

    hall        Random halls, all from one seed: rooms, doors, aisles, stations
    hall_maker  Stations, robots, goals and people in a random hall, where there is room for them
    halls       Runs in random halls: which runs a seed means, and how one is built and run
    report      Runs in random halls as Markdown: what was reached by size and trouble, what missed
    command     The command `swarm-bench halls`: its options

May import of swarm_bench: `runs`, `suite`.
"""

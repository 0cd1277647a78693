"""Seeded faults, crates and people: `storm`.

What a module imports of its folder stands above it:

    reachable  Which places a robot can get to among walls, crates and dead robots
    plan       What happens in a storm, drawn from its seed: failing navigators, crates, people
    storm      Storms: seeded runs in which navigators fail and come back among crates and people
    command    The command `python -m benchmarks storm`

May import of swarm_bench: `runs`, `suite`.
"""

"""Measures ourselves: `python -m benchmarks`. Not part of the wheel.

    measured_runs  The runs behind docs/results.md, and their results on disk
    results_page   docs/results.md from these results
    scale          What a swarm costs, by its size
    storm          Seeded faults, crates and people
    peers          Environments of others beside ours
    decisions      What a robot's decision costs, by its number of neighbours

May import every package; nobody imports it.
"""

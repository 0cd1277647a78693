"""Measures ourselves: `python -m benchmarks`. Not part of the wheel.

    measured_runs         The runs behind docs/results.md, and their results on disk
    results_page          docs/results.md from these results
    scale                 What a swarm costs, by its size
    storm                 Seeded faults, crates and people
    ablation              Each rule off, each number halved and doubled
    peers, peers_command  Other simulators and our harness on the same workload
    floor                 What messages, physics and rays cost at least
    profile_parts         Where the time of world and navigators goes, by module
    decisions             What a robot's decision costs, by its number of neighbours

May import every package; nobody imports it.
"""

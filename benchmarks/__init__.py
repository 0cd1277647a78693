"""Measures ourselves, for docs/performance.md: `python -m benchmarks`. Not part of the wheel.

    peers      Other simulators and our harness on the same workload
    floor      What messages, physics and rays cost at least
    profile    Where the time of world and navigators goes, by module
    decisions  What a robot's decision costs, by its number of neighbours

May import every package; nobody imports it.
"""

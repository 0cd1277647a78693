"""`swarm-bench study`: decentralised against central control, measured.

What a module imports of its folder stands above it:

    levels       Sizes and levels at which something changes; dips
    experiments  Experiments as written in `params/study/*.yaml`, and their runs
    bounds       The least time that a run can take
    lines        Raw results: one JSON line per run
    tuning       Equal tries for each method, and what was chosen
    runner       One run with its faults
    tables       From lines to tables
    page         docs/study.md and study.html
    command      The command: its options

May import of swarm_bench: `suite`, `execution`, `runs`, `statistics`, `tables`.
"""

"""`swarm-bench study`: decentralised against central control, measured.

What a module imports of its folder stands above it:

    trials/      One run, from its condition to its line
    experiments  Experiments as written in `params/study/*.yaml`: cells and hypotheses
    tuning       Equal tries for each method, and what was chosen
    verdicts     Verdicts of comparisons, and which runs they still need
    recovery     Times to recover
    tables       From lines and findings to tables
    figures      From lines to the figures
    page         docs/study.md, study.html and the protocol's tables
    command      The command: its options

May import of swarm_bench: `suite`, `execution`, `runs`, `statistics`, `tables`. The protocol is
`study/protocol.md`.
"""

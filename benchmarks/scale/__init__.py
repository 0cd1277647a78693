"""Cost of a swarm, by its size: `scale`.

What a module imports of its folder stands above it:

    harness  One run in one process, without the ROS graph: a program of its own
    result   Cost of one run, and a table row of several
    plan     Runs: which hall, how many robots, for how long
    runs     Runs one after the other, with their results kept on disk
    command  The command `benchmarks scale`: its options, and comparisons

May import of swarm_bench: `execution`, `runs`, `suite`, `tables`.
"""

"""Cost of a swarm, by its size: `scale`.

What a module imports of its folder stands above it:

    harness  One run of `benchmarks scale` in one process, without the ROS graph
    plan     What `benchmarks scale` runs: which hall, how many robots, for how long
    result   What one run of `benchmarks scale` cost, and the file of JSON lines that keeps it
    watch    Watches the processes of a run from outside: threads, memory, other users
    graph    One run of `benchmarks scale` on the ROS graph: `swarm-up`, watched from outside
    row      One table row for the runs of one system, workload and size, for terminal and Markdown
    process  One run of `benchmarks scale` in a process of its own that prints its result as JSON
    sweep    The runs of `benchmarks scale`, one after the other, with their results kept on disk
    compare  Two sweeps of `benchmarks scale` side by side: two files, or two commits
    command  The command `benchmarks scale`: its options, and what it writes

May import of swarm_bench: `runs`, `suite`.
"""

"""Sweeps: runs on processes of this machine or a cluster of Dask, and their results on disk.

What a module imports of its folder stands above it:

    task       One run in whatever process computes it: a result, or why there is none
    processes  The processes of this machine, each with a pipe; a run whose process dies is repeated
    cluster    The workers of a Dask cluster, which need the wheel and nothing else
    executor   Which of both the options mean
    store      Results on disk: JSON lines, one per run
    sweep      Many runs, each once, its result kept as it comes, with progress

May import of swarm_bench: `runs`.
"""

"""Sweeps: runs on processes of this machine or a cluster of Dask, and their results on disk.

What a module imports of its folder stands above it:

    task         One run in whatever process computes it: a result, or why there is none
    processes    Processes of this machine; a run whose process dies is repeated
    cluster      The workers of a Dask cluster, which need the wheel and nothing else
    slurm_array  Which share of the runs a task of a Slurm array does
    executor     Which of both the options mean
    store        Results on disk: JSON lines, one per run
    sweep        Many runs, each once, its result kept as it comes, with progress

May import of swarm_bench: `runs`.
"""

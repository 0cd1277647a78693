"""Each rule off, each number halved and doubled: `ablate`.

What a module imports of its folder stands above it:

    rules    What each liveness rule and number pays: the same runs with one of them changed
    command  The command `python -m benchmarks ablate`: its options

May import of swarm_bench: `halls`, `runs`, `suite`.
"""

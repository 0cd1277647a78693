"""Sweeps over scenarios and seeds: `traffic`, `suite`, `report-traffic`, and their tables.

What a module imports of its folder stands above it:

    store      Results on disk, so that a killed sweep can continue
    summary    Many runs of one scenario and size as one row
    table      Results for the terminal: a line per run, a table with a row per scenario and size
    report     The suite's tables as Markdown, from results
    sweep      Many runs on whatever computes them, with their results kept
    progress   Bars with an estimate for runs and for compiling
    selection  From the words on the command line to a list of runs
    command    The command `swarm-bench`: its options

May import of swarm_bench: `runs`, `execution`.
"""

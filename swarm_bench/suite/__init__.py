"""Sweeps over scenarios and seeds: `traffic`, `suite`, `report-traffic`, and their tables.

What a module imports of its folder stands above it:

    summary    Many runs of one scenario and size as one row
    table      Results for the terminal: a line per run, a table with a row per scenario and size
    report     The suite's tables as Markdown, from results
    sweep      Which runs are the same, and their results on disk
    selection  From the words on the command line to a list of runs
    command    The command `swarm-bench`: its options

May import of swarm_bench: `runs`, `execution`, `statistics`, `tables`.
"""

"""One run of the study, from its condition to its line; this code is part of a line's edition.

What a module imports of its folder stands above it:

    cell     Conditions under which methods run, and the runs in them
    bounds   The least time that a run can take
    line     Raw results: one JSON line per run
    trial    One run with its faults

May import of the study: nothing.
"""

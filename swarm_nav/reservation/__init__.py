"""The space that a robot holds, and the check that it stays there.

What a module imports of its folder stands above it:

    tube_kernels         Bare numba kernels: how far may a held tube grow? (rules G1 to G5)
    tube_view            Path and held space as rules and controllers see them: to be read only
    tube                 Safety layer: the space that a robot holds, asks for and announces
    stop_filter_kernels  Bare numba kernels of the stop filter

May import of swarm_nav: `perception`, `planning`, `core`; and swarm_common.
"""

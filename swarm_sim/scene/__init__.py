"""Flat sections of a world's geometry.

What a module imports of its folder stands above it:

    mesh_kernels     Numba kernels on the cut through a mesh: which points are inside
    polygon_kernels  Numba kernels on convex polygons: overlap and distance
    polygon_pieces   Polygons with holes as convex pieces
    randomness       Random numbers that depend on what they are for and on nothing else
    mesh_section     The part of a mesh between two heights, as polygons
    section          Bodies between two heights as convex polygons and discs

May import swarm_describe and swarm_common.
"""

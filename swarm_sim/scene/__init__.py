"""The geometry of a world after reading, and flat sections of it.

What a module imports of its folder stands above it:

    actors           People and vehicles that move beside the robots (`actors.yaml`)
    mesh_kernels     Numba kernels on the cut through a mesh: which points are inside
    polygon_kernels  Numba kernels on convex polygons: overlap and distance
    polygon_pieces   Polygons with holes as convex pieces
    randomness       Random numbers that depend on what they are for and on nothing else
    scene            A world's geometry after reading, and its named places
    mesh_section     The part of a mesh between two heights, as polygons
    overlaps         Models that lie inside others: a mistake of the world's author
    raw_triangles    The triangles of bodies as their files have them
    section          Bodies between two heights as convex polygons and discs
    floor            The floor that robots stand on, put at height 0

May import swarm_common only.
"""

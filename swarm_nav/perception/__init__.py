"""Surroundings of a robot: the others by radio, obstacles by LiDAR.

What a module imports of its folder stands above it:

    dynamic_obstacle_kernels  Bare numba kernels: which marks have moved, and how old they are
    neighbor_table_kernels    Bare numba kernels on the table of neighbours
    obstacle_kernels          Bare numba kernels of the obstacle layer
    absence_kernels           Bare numba kernels on robots that fell silent, and on sightings
    dynamic_obstacles         Decides which marks of the obstacle layer may be a walking person
    absence                   Robots that fell silent: dead where they were, or gone away?
    neighbor_table            The other robots, as known from their beacons alone
    obstacles                 Hits of the LiDAR that neither the map nor a beacon explains

May import of swarm_nav: `planning`, `core`; and swarm_common.
"""

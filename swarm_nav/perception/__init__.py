"""What a robot knows of its surroundings: the others by radio, obstacles by LiDAR.

What a module imports of its folder stands above it:

    dynamic_obstacle_kernels  Bare numba kernels: which marks have moved, and how old they are
    neighbor_table_kernels    Bare numba kernels on the table of neighbours: beacons as rows of
                              4-byte words, by id
    obstacle_kernels          Bare numba kernels of the obstacle layer
    absence_kernels           Bare numba kernels on robots that fell silent where they may have left
                              the radio range
    dynamic_obstacles         Decides which marks of the obstacle layer may be a walking person
    station_kernels           Bare numba kernels on the table of neighbours: the robots that wait
                              for a station
    absence                   Robots that fell silent where they may have left the radio range: dead
                              there, or gone away?
    neighbor_table            What a robot knows of the others, from their beacons alone
    obstacles                 Obstacle layer: what the LiDAR sees that neither the map nor a beacon
                              explains

May import of swarm_nav: `planning`, `core`; and swarm_common.
"""

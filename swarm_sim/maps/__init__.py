"""The map of a world, whether it shows it, and where robots can stand and go.

What a module imports of its folder stands above it:

    raster          Drawing of a section onto an occupancy grid
    draw_map        The map of a world: what a LiDAR sees of it, and what robots can touch
    map_difference  Differences between a map and its world: counted, named and drawn
    spawn           Starts of robots: on a lattice away from walls, or on a circle
    world_check     Do map, LiDARs and physics engine show a world as its file has it?
    check           Does the map show this world, and is there room at the stations?
    passages        Can every robot get to every station? If not: the passage in the way

May import of swarm_sim: `physics`, `scene`; and lower packages.
"""

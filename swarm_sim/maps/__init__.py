"""The map of a world, whether it shows it, and where robots can stand and go.

What a module imports of its folder stands above it:

    raster          Drawing of a section onto an occupancy grid
    draw_map        The map of a world: what a LiDAR sees of it, and what robots can touch
                    beside that
    map_difference  Where a map disagrees with the world that it should show: counted, named and
                    drawn
    spawn           Where robots start: on a lattice away from walls, stations and circuits, or
                    on a circle
    world_check     Checks that map, LiDARs and physics engine show a world as its file
                    describes it
    check           Checks at the start: does the map show this world, and is there room at the
                    stations?
    passages        Can every robot get to every station? If not: which passage is too narrow,
                    and how narrow

May import of swarm_sim: `physics`, `sdf`, `scene`; and swarm_common.
"""

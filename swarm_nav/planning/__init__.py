"""The way through the map: clearances and lanes, search on the lattice, paths.

What a module imports of its folder stands above it:

    distance_kernels   Bare numba kernels on distance fields; checked faces are in terrain.py and
                       traffic_costs.py
    path_cost_kernels  Bare numba kernels that judge paths: their cost, and whether they clear
                       another robot's way
    search_kernels     Bare numba kernels of graph search on the planning lattice: cost-to-go, A*,
                       nearest place
    oblong_kernels     Bare numba kernels for long robots: where the polygon fits, and what a twist
                       would touch
    path_kernels       Bare numba kernels on paths: resampling, smoothing, corners; checked faces
                       are in planner.py
    oblong             Long robots: passages that the footprint fits through straight, but not the
                       circle around it
    search             The lattice and the work arrays as the search kernels take them
    terrain            What a robot derives from the shared map once: clearances, keep-right lanes,
                       parking places
    planner            Global planner: A* on the lattice, smoothed to a path that a differential
                       drive can follow

May import of swarm_nav: `core`; and swarm_common.
"""

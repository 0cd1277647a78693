"""The way through the map: clearances and lanes, search on the lattice, paths.

What a module imports of its folder stands above it:

    cells              Distances between cells, and the parts of a grid that hang together
    distance_kernels   Bare numba kernels on distance fields
    path_cost_kernels  Bare numba kernels that judge paths: what they cost, whom they clear
    search_kernels     Bare numba kernels of search: cost-to-go, A*, nearest place
    oblong_kernels     Bare numba kernels for long robots: where the polygon fits
    path_kernels       Bare numba kernels on paths: resampling, smoothing, corners
    oblong             Long robots: passages that only the footprint fits through
    directed           Directed zones: the moves that they close, or make dear
    search             The lattice and the work arrays as the search kernels take them
    terrain            Clearances, lanes and parking places, derived once from the map
    planner            Global planner: A* on the lattice, smoothed to a drivable path
    plugin_planner     A global planner that a user brings, behind the face of the built-in one

May import of swarm_nav: `interfaces`, `core`; and swarm_common.
"""

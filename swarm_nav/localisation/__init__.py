"""Localisation in the map: odometry alone, or Monte Carlo localisation.

What a module imports of its folder stands above it:

    amcl_kernels     Bare numba kernels of Monte Carlo localisation
    likelihood       Likelihood that a LiDAR hit lies at a place of the map
    particle_filter  The particles: moved by odometry, weighted by scans, resampled
    amcl             Adaptive Monte Carlo localisation on a likelihood field
    plugin_localiser  A localiser that a user brings, behind the face of the built-in ones
    localiser        Dead reckoning, and which localiser the parameters ask for

May import of swarm_nav: `perception`, `planning`, `interfaces`, `core`; and swarm_common.
"""

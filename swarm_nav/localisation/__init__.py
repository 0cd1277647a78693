"""Where the robot is in the map: odometry alone, or Monte Carlo localisation.

What a module imports of its folder stands above it:

    amcl_kernels     Bare numba kernels of Monte Carlo localisation; the checked face is in
                     amcl.py
    correction       How a correction of the pose enters it: bit by bit, so that the robot does
                     not leap
    likelihood       Likelihood fields: how probable it is that a LiDAR hit lies at a place of
                     the map
    particle_filter  The particles of Monte Carlo localisation: moved by odometry, weighted by
                     scans, resampled
    amcl             Adaptive Monte Carlo localisation (Fox 2003; Thrun, Burgard, Fox 2005) on a
                     likelihood field
    localiser        Where the robot is in the map. The seam for scan matching: anything with
                     this interface

May import of swarm_nav: `perception`, `planning`, `core`; and swarm_common.
"""

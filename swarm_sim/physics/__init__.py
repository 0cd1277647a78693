"""The engines, and what moves in them beside the robots.

What a module imports of its folder stands above it:

    drive            Between commands and wheels: speeds to aim at, and odometry
    engine           Interface of a physics engine; `planar` and `bullet` implement it
    walker_kernels   Numba kernels of the walkers: a step, and their distance from robots
    planar_kernels   Numba kernels of the kinematic engine
    scripted_paths   Base of walkers and vehicles: closed paths, pauses, contacts
    vehicle_kernels  Numba kernel of vehicles: drive, turn on the spot, wait
    actors           Walkers and vehicles on scripted paths: poses, and contacts with robots
    objects          Bodies that move besides robots and walkers: loose things, and vehicles
    planar           Kinematic twin of the physics engine: fast, for thousands of traffic runs
    bullet           The rigid-body engine: pybullet, and the bodies that it is given
    trial            The trial of a robot model, alone on the ground

May import of swarm_sim: `scene`; and lower packages.
"""

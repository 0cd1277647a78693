"""The engines, and what moves in them beside the robots.

What a module imports of its folder stands above it:

    drive            Between commands and wheels: which speeds robots aim at, and what their
                     odometry makes of it
    engine           What the world asks of a physics engine; `planar` and `bullet` implement it
    walker_kernels   Numba kernels of the walkers: one step along their loops, and their distance
                     from robots
    planar_kernels   Numba kernels of the kinematic engine
    scripted_paths   Base of walkers and vehicles: closed scripted paths, pauses, and contacts with
                     robots
    vehicle_kernels  Numba kernel of vehicles on scripted paths: drive, turn on the spot, wait for
                     standing robots
    vehicles         Forklifts and other vehicles on scripted paths: poses, and contacts with robots
    walkers          People who walk among the robots: positions, and contacts with robots
    objects          What moves in a world beside robots and walkers: things that can be pushed, and
                     vehicles
    planar           Kinematic twin of the physics engine: fast, for thousands of traffic runs
    bullet           The rigid-body engine: pybullet, and the bodies that it is given
    trial            The trial of a robot model: alone on the ground, half a metre ahead, a quarter
                     turn, a curve

May import of swarm_sim: `scene`; and swarm_common.
"""

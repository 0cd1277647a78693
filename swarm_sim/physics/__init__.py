"""The engines, and what moves in them beside the robots.

What a module imports of its folder stands above it:

    bullet_shapes        Collision shapes of pybullet, of one or several of ours
    bullet_supports      What a robot stands on in the rigid-body engine: its driven wheels, and
                         balls without friction
    drive                Between commands and wheels: which speeds robots aim at, and what their
                         odometry makes of it
    engine               What the world asks of a physics engine; `planar` and `bullet` implement it
    walker_kernels       Numba kernels of the walkers: one step along their loops, and their
                         distance from robots
    bullet_fixed         Bodies of pybullet that nothing pushes, the ground, obstacles, walkers; and
                         collision groups
    scripted_paths       Base of walkers and vehicles: closed scripted paths, pauses, and contacts
                         with robots
    planar_kernels       Numba kernels of the kinematic engine
    vehicle_kernels      Numba kernel of vehicles on scripted paths: drive, turn on the spot, wait
                         for standing robots
    bullet_kernels       Numba kernels around the rigid-body engine: speed ramps and the search for
                         near pairs
    bullet_robots        Rigid bodies of robots for pybullet
    vehicles             Forklifts and other vehicles on scripted paths: poses, and contacts with
                         robots
    walkers              People who walk among the robots: positions, and contacts with robots
    objects              What moves in a world beside robots and walkers: things that can be pushed,
                         and vehicles
    bullet_objects       Concave meshes, things that can be pushed, and vehicles, for pybullet
    planar               Kinematic twin of the physics engine: fast, for thousands of traffic runs
    bullet_contacts      Near pairs and contacts of bodies in the rigid-body engine
    bullet_probe         What the physics engine has where a body should be
    bullet_surroundings  All that robots can touch in the rigid-body engine: fixed bodies, objects,
                         and walkers
    bullet               Rigid-body engine: pybullet without a window, wheels turned by velocity
                         motors
    trial                The trial of a robot model: alone on the ground, half a metre ahead, a
                         quarter turn, a curve

May import of swarm_sim: `scene`; and swarm_common.
"""

"""The rigid-body engine: pybullet, and the bodies that it is given.

What a module imports of its folder stands above it:

    bullet_kernels    Numba kernels around the rigid-body engine: speed ramps and the search for
                      near pairs
    collision_shapes  Collision shapes of pybullet, of one or several of ours
    supports          What a robot stands on in the rigid-body engine: its driven wheels, and balls
                      without friction
    contacts          Near pairs and contacts of bodies in the rigid-body engine
    fixed_bodies      Bodies of pybullet that nothing pushes, the ground, obstacles, walkers; and
                      collision groups
    object_bodies     Concave meshes, things that can be pushed, and vehicles, for pybullet
    robot_bodies      Rigid bodies of robots for pybullet
    probe             What the physics engine has where a body should be
    surroundings      All that robots can touch in the rigid-body engine: fixed bodies, objects, and
                      walkers
    bullet_engine     Rigid-body engine: pybullet without a window, wheels turned by velocity motors

May import of swarm_sim: the modules of `physics` above it, and `scene`; and swarm_common.
"""

"""The rigid-body engine: pybullet, and the bodies that it is given.

What a module imports of its folder stands above it:

    bullet_kernels    Numba kernels of this engine: speed ramps, and near pairs
    collision_shapes  Collision shapes of pybullet, of one or several of ours
    supports          Supports of a robot: driven wheels, and balls without friction
    contacts          Near pairs and contacts of bodies in the rigid-body engine
    fixed_bodies      Bodies that nothing pushes: ground, obstacles, walkers
    object_bodies     Concave meshes, things that can be pushed, and vehicles, for pybullet
    robot_bodies      Rigid bodies of robots for pybullet
    probe             Shapes that the physics engine has in place of those of a body
    surroundings      All that robots can touch: fixed bodies, objects, and walkers
    bullet_engine     Rigid-body engine: pybullet without a window, wheels turned by velocity motors

May import of swarm_sim: the modules of `physics` above it, and `scene`; and lower packages.
"""

"""The world as viewers see it.

What a module imports of its folder stands above it:

    markers          Bodies as markers for those who look at the world
    scene_publisher  Geometry once, and poses of all robots every tick if wanted

May import of swarm_sim: what `ros` may, but of `ros` itself nothing; and lower packages.
"""

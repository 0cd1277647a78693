"""Worlds of Gazebo, and what is in a world after reading.

What a module imports of its folder stands above it:

    actors           People and vehicles that move beside the robots (`actors.yaml`)
    scene            A world's geometry after reading, and its named places
    raw_triangles    The triangles of bodies as their files have them
    floor            The floor that robots stand on, put at height 0
    overlaps         Models that lie inside others: a mistake of the world's author
    other_worlds     Floor plans, maps and worlds of other programs: how to make a world of them
    world_file       Where a world is: one of `worlds/`, the user's own, or one of Gazebo Fuel
    frames           Frames of an SDF file: `relative_to`, `<frame>`, names inside nested models
    shapes           Geometry of collisions and visuals in an SDF file, and colours of materials
    source           SDF files as elements: parsing, versions, missing files
    grammar          Rules for the elements of an SDF file
    scripted_actors  Actors with a script: walkers, or vehicles if they have a box
    models           The tree of models: models in models, and included ones
    bodies           Bodies from models: links with their shapes
    reader           Reading of SDFormat worlds (Gazebo's `.sdf` and `.world`) into a `Scene`

May import of swarm_describe: `files`; and swarm_common.
"""

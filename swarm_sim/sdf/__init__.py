"""Reading of Gazebo's world files.

What a module imports of its folder stands above it:

    meshes       Reading of mesh files (.dae, .stl, .obj, ...) for collisions
    model_paths  Where the models and meshes are that a world file names by URI
    values       Numbers, poses and colours in the elements of an SDF file, checked as they are
                 read
    frames       Frames of an SDF file: `relative_to`, `<frame>`, and names inside nested models
    shapes       Geometry of collisions and visuals in an SDF file, and the colours of materials
    source       SDF files as elements: parsing, versions, files that are missing, and what is
                 ignored
    actors       Actors of an SDF world: an actor with a script becomes a walker, or a vehicle
                 if it has a box
    models       The tree of models in an SDF world: models in models, and models included from
                 other files
    state        The `<state>` of an SDF world: poses that models and links had when the world
                 was saved
    bodies       From the models of an SDF world to bodies: links with their shapes, where
                 `<state>` has them
    reader       Reading of SDFormat worlds (Gazebo's `.sdf` and `.world`) into a `Scene`

May import of swarm_sim: `scene`; and swarm_common.
"""

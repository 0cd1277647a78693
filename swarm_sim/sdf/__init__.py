"""Reading of Gazebo's world files.

What a module imports of its folder stands above it:

    xml_reader   XML as Gazebo's reader takes it
    meshes       Reading of mesh files (.dae, .stl, .obj, ...) for collisions
    model_paths  Places of the models and meshes that a world file names by URI
    values       Numbers, poses and colours in elements, checked as they are read
    frames       Frames of an SDF file: `relative_to`, `<frame>`, and names inside nested models
    shapes       Geometry of collisions and visuals in an SDF file, and the colours of materials
    source       SDF files as elements: parsing, versions, missing files
    grammar      Rules for the elements of an SDF file
    actors       Actors with a script: walkers, or vehicles if they have a box
    models       The tree of models: models in models, and included ones
    state        The `<state>` of a world: poses when it was saved
    bodies       Bodies from models: links with their shapes
    reader       Reading of SDFormat worlds (Gazebo's `.sdf` and `.world`) into a `Scene`

May import of swarm_sim: `scene`; and swarm_common.
"""

"""Files of descriptions: where they are, XML, xacro, meshes.

What a module imports of its folder stands above it:

    faults        A list of everything that is wrong with one thing, reported at once
    packages      ROS packages on disk: where `package://` URIs and `$(find package)` lead
    fuel          Models and worlds of Gazebo Fuel in the user's cache
    model_paths   Places of the models and meshes that a world file names by URI
    xml_reader    XML as Gazebo's reader takes it
    values        Numbers, poses and colours in elements, checked as they are read
    xacro_compat  The private parts of xacro that we use, all in one place
    xacro_io      Expansion of xacro files, with errors that name file and line
    meshes        Mesh files in metres, and their convex hulls

May import of swarm_common: `files`, `model`, `process`.
"""

"""Files that are read and written: maps, sites, caches, the data that ships with the project.

What a module imports of its folder stands above it:

    bytecode    Byte code of our modules where Python is told not to keep any
                (PYTHONDONTWRITEBYTECODE)
    edition     Which edition of the software this is: hosts of one swarm must run the same
    home        Where things are kept between runs if the user has no home folder, or one that
                is read-only
    journal     Append-only files of JSON lines: everything written stays readable if the writer
                is killed
    map_image   Images of maps as Nav2's map_server sees them: brightness of each pixel, and its
                opacity
    quiet       Libraries that write on the terminal what our own messages say better
    resources   Where the data that ships with the project lives: robots, worlds, maps, params,
                interfaces
    whole_file  Files that are there whole or not at all, whatever happens to the writer or the
                disk
    yaml_io     Strict reading of YAML files: malformed text, unknown keys and wrong types are
                errors
    cache       Results kept in the user's cache between runs
    map_io      Reading and writing of maps in Nav2's format: a YAML file beside a greyscale
                image
    meshes      Mesh files (STL, DAE, OBJ and what else trimesh reads) as convex hulls
    sites_io    Reading of `sites.yaml`: stations, holding circuits, spawns and places of a
                world

May import of swarm_common: `model`, `process`.
"""

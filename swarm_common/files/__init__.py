"""Files that are read and written: maps, sites, caches, the data that ships with the project.

What a module imports of its folder stands above it:

    journal     Append-only files of JSON lines that stay readable if the writer is killed
    map_image   Images of maps as Nav2's map_server sees them
    trajectory_io  True poses of every robot at every tick, in a file
    storage     Files that are there whole or not at all; results kept in the cache
    yaml_io     Strict reading of YAML files
    convert     The one door for settings: values become typed values, or ConfigError
    resources   Folders of the data that ships with the project, and of runs
    map_io      Reading and writing of maps in Nav2's format
    params_io   ROS 2 parameter files: sections by node name, and which node each is for
    zones_io    Reading of zones: the section `zones:` of `sites.yaml`, and Nav2's filter masks
    sites_io    Reading of `sites.yaml`
    layout_io   Reading of layouts of fleet controls (LIF)

May import of swarm_common: `model`, `process`.
"""

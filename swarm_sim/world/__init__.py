"""The world in lockstep, who is in it, and the verdict on a run.

What a module imports of its folder stands above it:

    close_calls       Near misses: episodes that came very close, without contact
    batteries         The batteries of all robots that have one, over simulated time
    request_checks    Limits on every `/sim` request, and why a change is refused
    object_source     Descriptions of things that come at run time: SDF or URDF
    zone_watch        Ground truth about zones: who was in a keepout zone, or too fast
    verdict           Ground truth: collisions, clearances, distances, hash of trajectories
    model_reader      Reads models for the world in a process of its own
    world             The world in lockstep: observe at a tick, take commands, advance
    setup             A world before it starts: scene, robots, starts and map
    changing_world    A world in which robots and things come, go and are moved
    object_placement  Whether an object may be put somewhere while robots drive
    robot_placement   Whether a robot may be put somewhere while others drive
    robot_registry    The robots in the world: which may come, go or be put elsewhere. Knows no ROS
    object_registry   The objects in the world: which may come, go or be put elsewhere. Knows no ROS

May import of swarm_sim: `sensing`, `maps`, `physics`, `scene`; and lower packages.
"""

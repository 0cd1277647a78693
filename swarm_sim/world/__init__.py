"""The world in lockstep, who is in it, and the verdict on a run.

What a module imports of its folder stands above it:

    close_calls       Near misses: episodes in which a robot came very close to something, but did
                      not touch it
    refusal           Why a change of the world is refused
    object_source     Descriptions of things that come at run time: SDF or URDF, a file, a model's
                      folder or a text
    request_checks    Limits on the content of every `/sim` request, whatever it asks for
    verdict           Ground truth about a run: collisions, clearances, distances and a hash of all
                      trajectories
    model_reader      Reads models for the world in a process of its own
    world             The world in lockstep: observe all robots at a tick, take their commands,
                      advance one tick
    changing_world    A world in which robots come and go, and robots and things are put elsewhere,
                      between ticks
    object_placement  Checks of places for objects that are added or moved while robots
                      drive
    robot_placement   Whether a robot may be put somewhere while others drive: room to stand, and
                      nobody on the way
    robot_registry    The robots in the world: which may come, go or be put elsewhere. Knows no ROS
    object_registry   The objects in the world: which may come, go or be put elsewhere. Knows no ROS

May import of swarm_sim: `sensing`, `maps`, `physics`, `sdf`, `scene`; and swarm_common.
"""

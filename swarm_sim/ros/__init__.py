"""The world on the ROS graph, and its process.

What a module imports of its folder stands above it:

    barrier          Lockstep: the robots that have answered the current tick, and those awaited. No
                     clock, no I/O
    foreign          Publishers on a robot's topics that have no business there: found, named once,
                     ignored
    frames           Frames of a robot for its viewers: what robot_state_publisher would send
    hosts            Robots whose navigators are on other hosts: the radio's beacons go there in
                     batches
    markers          Bodies as markers for those who look at the world
    model_loader     Models are read by a process beside the world, which goes on meanwhile
    moves            Tells navigators that their robots were put elsewhere, and holds these until
                     they know
    name_pattern     Filters on names: POSIX extended regular expressions, matched in linear time by
                     RE2
    pacing           Throttle to a multiple of real time, and rates that are limited on the wall
                     clock
    places           Places and twists of robots and things as messages, and back
    round_trip       How long to wait for an answer before it is asked for again. No clock, no I/O
    run_state        Whether the world runs: playing, paused, or paused with steps to do
    settings         Configuration of the world process: a JSON file that swarm-up writes
    build            From the settings to a world: everything that can be refused is refused here
    control          Pause, step and speed of the world: simulation_interfaces' services and a
                     parameter
    request_door     How a request to `/sim` ends: whatever goes wrong with it becomes its answer
    entities         simulation_interfaces' services that change who and what is there: spawn,
                     delete, move, reset
    inquiries        simulation_interfaces' questions, which are answered at once, and what is not
                     supported
    links            One robot's topics on the side of the world
    movers           Who and what moves beside the robots, as markers that keep their ids
    report           What the world says of a run: twice a second while it goes on, and at its end
    scene_publisher  The world for those who look at it: geometry once, poses of all robots every
                     tick if wanted
    swarm            The topics of all robots on the side of the world, in the order of robots
    trace            Light time series of the truth for the report: where everybody was, once a
                     second
    world_node       The world as a node: what happens between two ticks, and in one
    node             The world's process: `python -m swarm_sim.ros.node CONFIG.json [--event-fd N]
                     [--control-fd M]`

May import of swarm_sim: `world`, `sensing`, `maps`, `physics`, `sdf`, `scene`; and
swarm_common.
"""

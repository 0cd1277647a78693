"""The robots' topics on the side of the world, and the lockstep with their navigators.

What a module imports of its folder stands above it:

    barrier     Lockstep: who has answered the current tick, and who is awaited
    foreign     Publishers on a robot's topics that have no business there
    frames      Frames of a robot for its viewers: what robot_state_publisher would send
    moves       Tells navigators that their robots were put elsewhere
    round_trip  Time to wait for an answer before it is asked for again. No clock, no I/O
    links       One robot's topics on the side of the world
    swarm       The topics of all robots on the side of the world, in the order of robots

May import of swarm_sim: what `ros` may, of `ros` itself `build` and `settings`; and lower packages.
"""

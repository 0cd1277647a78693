"""The world: physics, sensing, radio and ground truth; imports swarm_describe and swarm_common.

Lower folders never import higher ones; the lowest stands first:

    scene    Flat sections of a world's geometry
    physics  The engines, and what moves in them beside the robots
    sensing  LiDARs, encoders and the radio
    maps     The map of a world, whether it shows it, and where robots can stand and go
    world    The world in lockstep, who is in it, and the verdict on a run
    ros      The world on the ROS graph, and its process

Arrays have one row per robot, in the order of their indices, unless a docstring says otherwise:

- `poses` (n, 3): true x, y, yaw in the map frame; `twists` (n, 3): vx, wz, vy of base_footprint.
- `travels` (n, 2): way forwards and to the left since the start; `yaws` (n,): turned since then.
- `clearances` (n, 2): distance to the nearest robot and obstacle; inf where there is none.
- `walkers` (m, 3): x, y, radius of each.
- Transforms are (4, 4); the place of a body is world from body. `index` of a thing is among
  `Objects.loose`.
"""

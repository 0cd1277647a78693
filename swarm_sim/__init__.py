"""The world: physics, sensing, radio and ground truth; imports swarm_common only.

Lower folders never import higher ones; the lowest stands first:

    scene    The geometry of a world after reading, and flat sections of it
    physics  The engines, and what moves in them beside the robots
    sdf      Reading of Gazebo's world files
    sensing  LiDARs, encoders and the radio
    maps     The map of a world, whether it shows it, and where robots can stand and go
    world    The world in lockstep, who is in it, and the verdict on a run
    ros      The world on the ROS graph, and its process
"""

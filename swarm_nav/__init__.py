"""One robot: its navigator; imports swarm_common only.

Lower folders never import higher ones; the lowest stands first:

    core          Terms that all parts of a navigator share: its parameters, goals, states and
                  priorities
    interfaces    The parts of a robot that users can replace: typed protocols
    planning      The way through the map: clearances and lanes, search on the lattice, paths
    perception    Surroundings of a robot: the others by radio, obstacles by LiDAR
    reservation   The space that a robot holds, asks for and announces
    localisation  Localisation in the map: odometry alone, or Monte Carlo localisation
    control       Controllers: twists with which a robot follows its path
    traffic       Rules between robots: reservation of space, right of way, stations, narrow regions
    behaviour     Behaviour of a robot, tick by tick: goals, states, recoveries, announcements
    ros           The navigator on the ROS graph: messages in, one call of the brain per tick,
                  messages out
    launch        Starting navigators: one warm parent that forks a process per robot
"""

import swarm_common  # noqa: F401  # decides whether what follows is compiled

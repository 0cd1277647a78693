"""Values that all parties speak of.

What a module imports of its folder stands above it:

    engines   The default physics engine: PyBullet is not available for all versions of Python
    errors    Errors that carry a message for the user: what was found, where, what to do
    breaches   Breaches in a run: collisions, and goals that are not reached
    schema    Words in which settings are declared: a base, and constraints that are asked often
    battery   A robot's battery: what it holds, and what driving takes from it
    sensors    Errors of a robot's sensors: the section `sensors:` of robot.yaml
    shapes     Collision shapes and where they sit
    grid     Occupancy grid in Nav2's sense: the one central thing that robots share
    outline  Outlines of bodies seen from above, and what else follows from their shapes
    palette    The colours of all pages and pictures, and what each state of a robot means
    records    Values that cross a topic, as plain dataclasses
    central   Who coordinates the traffic; messages between robots and a centre
    robot_parameters  A robot model as the ROS parameters `robot.*` of its navigator, and back
    robot_names  Names of a run's robots: their namespaces, by the number that beacons carry
    run_words  Words that terminal and report.html share, from the fields of report.json
    beacon   The radio message: `Beacon` as a numpy record whose bytes are its CDR body
    zones    Keepout zones and speed limits on a map, as Nav2's costmap filters have them
    sites    Named places of a world: stations, circuits, spawns, places and zones (`sites.yaml`)

May import nothing else of swarm_common.
"""

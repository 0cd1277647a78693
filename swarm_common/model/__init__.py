"""Values that all parties speak of.

What a module imports of its folder stands above it:

    engines   The default physics engine: PyBullet is not available for all versions of Python
    coordination  Parties that coordinate the traffic of the robots
    central   Messages between robots and a centre that decides for them
    breaches   Breaches in a run: collisions, and goals that are not reached
              reached
    errors    Errors that carry a message for the user: what was found, where, what to do
    schema    Words in which settings are declared: a base, and constraints that are asked often
    battery   A robot's battery: what it holds, and what driving takes from it
    sensors    Errors of a robot's sensors: the section `sensors:` of robot.yaml
             ideal
    shapes     Collision shapes and where they sit
             descriptions
    grid     Occupancy grid in Nav2's sense: the one central thing that robots share
    outline  Outlines of bodies seen from above, and what else follows from their shapes
    palette    The colours of all pages and pictures, and what each state of a robot means
             means
    records    Values that cross a topic, as plain dataclasses
             exchange
    robot_parameters  A robot model as the ROS parameters `robot.*` of its navigator, and back
    robot_names  Names of a run's robots: their namespaces, by the number that beacons carry
    run_words  Words that terminal and report.html share, from the fields of report.json
    beacon   The radio message: `Beacon` as a numpy record whose bytes are its CDR body
    way_graph  Graph of free cells, for shortest ways over eight neighbours
    zones    Keepout zones and speed limits on a map, as Nav2's costmap filters have them
    sites    Named places of a world: stations, circuits, spawns, places and zones (`sites.yaml`)

May import nothing else of swarm_common.
"""

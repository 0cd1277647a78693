"""A centre that decides for all robots, to compare our decentralised rules with.

What a module imports of its folder stands above it:

    team              Interface of a method that decides for all robots, and its messages
    config            Parameters of the centre
    roadmap_kernels   Times from all vertices to a goal
    roadmap           Vertices, lanes and costs made from a map
    pibt_kernels      Priority inheritance with backtracking: one step of all robots
    lacam             LaCAM*: a whole plan for all robots
    plan_check        Checks whether a joint plan can be driven, and names its fault if not
    program           A program of others, for a limited time
    movingai          Maps, scenarios and paths of other solvers
    dependency_graph  In which order robots enter each vertex, whatever their delays
    grant_kernels     Distance that a robot may drive, by where the others may be
    progress          State of one robot as the centre knows it, and how far it may drive
    mapf              The centre: plans, and lets robots drive as far as the plan's order allows

    reservation       A centre over our own navigators: it gives each its way
    link              The centre's side of the radio, on the graph
    process           The process that swarm-up starts

It knows maps and messages. It imports nothing of the bench, the world or the operator.
"""

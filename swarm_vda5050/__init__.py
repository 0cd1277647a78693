"""Robots of a swarm as vehicles of VDA 5050: orders over MQTT in, states out.

    standard     The standard in tables: fields of messages by version
    reading      Messages against the tables
    messages     The messages as they are inside this package
    faults       The errors that a robot reports
    fine         The moves of a fine positioning
    actions      The actions that robots offer
    order_check  Whether an order makes sense in itself
    tally        Orders of a run in numbers
    maps         The maps of a robot
    map_server   Maps fetched, checked and compared with the world's
    vehicle      One robot's orders, actions and state: the protocol, without input and output
    requests     What a robot asks for: zones, ways through them, corridors; of version 3.0
    zone_actions  Actions in ACTION zones of version 3.0
    zones        Zone sets of version 3.0
    ways         Corridors and trajectories of edges, as ways and floor for the navigator
    simulated_faults  Faults on demand
    conformance  The verdict on the fleet control
    paths        The paths that a robot tells
    dialect      Messages of a version on the wire
    factsheet    What a robot model can do
    broker       A mosquitto of our own on loopback
    link         The MQTT connection of one robot
    pilot        One robot of the swarm, driven as its vehicle wants
    process      The process that swarm-up starts

May import swarm_common and swarm_run.
"""

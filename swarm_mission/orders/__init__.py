"""Transport orders: who wants what moved when, who takes it, and what became of it.

What a module imports of its folder stands above it:

    service        How long a robot is served at a station: constant or random
    arrivals       When the orders of a stream come
    order          One order, and streams of them
    order_file     The keys `orders`, `groups`, `dispatch` and `capacity` of a mission file
    way_lengths    How far it is from anywhere to a station, around walls
    demand         Whether stations and robots can serve the orders at all: said before a run
    messages       What stations and robots say to each other over the radio
    radio          Loses and delays these messages as the world's radio does beacons
    order_barrier  Who has spoken in a tick, and when the next one may begin
    states         States of an order at its station, and of a robot with it
    station_agent  One station: announces its orders, grants each, takes it back, hands goods over
    robot_bidder   One robot: bids for orders, reports on those that it holds
    courier        Takes one robot through its orders: where it is to drive next
    dispatch       Who gets an order: robots by their claims, or a dispatcher to compare with
    order_book     What became of every order, station and robot
    floor_use      How much of the floor is used: flow and density
    order_run      All stations and robots of one process, over one radio

No module has a clock or does I/O, but `order_file` reads files. May import swarm_common only.
"""

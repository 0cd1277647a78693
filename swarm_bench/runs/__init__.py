"""Scenarios, and one run of them in one process or on the ROS graph, up to its result.

What a module imports of its folder stands above it:

    document           Parts of a document that a command writes, between two lines that mark them
    invariant_kernels  The smallest gap between held tubes, in every tick
    inputs             What runs are made from: read once, hashed, sent to other processes
    origin             Where a result comes from: code, inputs, machine
    methods            What drives a robot in the bench: our navigator, or a baseline
    scenario           Scenarios: the rows of the traffic suite
    invariant          No two robots hold space nearer to each other than their radii
    result             Lines of a result file: a run's record, or why there is none
    ground_truth       Standing, circles and deadlocks as the simulator sees them
    orders             Orders in the bench: goals come from what stations and robots agree on
    episode            Everything that a run needs, made from a scenario
    fingerprint        A hash of everything that a run is made from
    result_builder     From a run that is over to its record
    harness            One run without the ROS graph, tick by tick
    ros_run            One run on the real ROS graph, by `swarm-up`

Imports nothing else of swarm_bench.
"""

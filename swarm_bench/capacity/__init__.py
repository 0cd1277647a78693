"""How many robots a hall is good for: throughput and lead time over robots.

What a module imports of its folder stands above it:

    knee       The number of robots from which more of them bring little, with its interval
    curve      The runs of one variant at all swarm sizes, as points with intervals
    findings   What the curves say, in sentences that hold over the seeds, or none
    axes       From the words on the command line to the variants of a study
    study      Which runs come next, until all intervals are narrow or the time is up
    report     Results as a page with plots, as CSV and as JSON
    command    The command `swarm-bench sweep`
    on_graph   `swarm-up --sweep`: a run on the ROS graph for each value

May import of swarm_bench: `runs`, `execution`, `suite`, `statistics`, `tables`.
"""

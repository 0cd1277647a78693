"""Other ways to drive the robots: honest, competent versions of the usual methods, to compare.

They get what our navigator gets (map, odometry, scans, beacons within radio range), share its
A* planner without lanes, and decide each robot for itself. Imported by swarm_bench.runs.methods
only.
"""

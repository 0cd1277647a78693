"""Our navigator and DWA without coordination, in the same runs.

python examples/compare.py [SEEDS]
"""

import sys

from swarm_workbench import run_scenario

SEEDS = int(sys.argv[1]) if len(sys.argv) > 1 else 5

for brain in ("ours", "dwa"):
    results = [run_scenario("circle", robots=4, seed=seed, brain=brain) for seed in range(SEEDS)]
    reached = sum(result.goals_reached for result in results)
    sent = sum(result.goals_sent for result in results)
    contacts = sum(result.robot_robot + result.robot_world for result in results)
    print(f"{brain}: {reached} of {sent} goals reached, {contacts} collisions")

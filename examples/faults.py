"""A robot dies on its way; the others, who hear nothing of it any more, go around it."""

from swarm_workbench import Swarm

with Swarm(robots=3, world="slim_blockage", seed=1, bench=True) as swarm:
    first, second, third = swarm
    goals = [first.go_to("loader_1"), second.go_to("loader_2"), third.go_to("loader_3")]
    swarm.run(seconds=8.0)
    first.fail()
    for goal in goals[1:]:
        print(goal.robot, goal.wait())
    print(f"{first.name} stands at {first.true_pose}; {swarm.report.collisions} collisions")
    swarm.plot().figure.savefig("faults.png", dpi=80)

"""A world of walls, a box and two stations; two robots change places in it."""

from swarm_workbench import Swarm, World

CORNERS = [(-4, -3), (4, -3), (4, 3), (-4, 3)]
world = World.create(
    "my_world",
    walls=[(*a, *b) for a, b in zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True)],
    boxes=[(0, 0, 1, 2)],
    stations={"west": (-3, 0, 0), "east": (3, 0, 3.14)},
)
with Swarm(robots=2, world=world, bench=True) as swarm:
    first, second = swarm
    for there, back in (("west", "east"), ("east", "west")):
        goals = [first.go_to(there), second.go_to(back)]
        print([goal.wait().duration for goal in goals])
    swarm.plot().figure.savefig("own_world.png", dpi=80)

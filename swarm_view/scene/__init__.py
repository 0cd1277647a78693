"""Drawings in 3D, and the camera that looks at them; parts of viser that are not public.

What a module imports of its folder stands above it:

    chase         The camera that goes with a robot
    images        Grids as images: the map in grey, costs in colours over it
    shapes        Points and meshes for viser, from arrays in the plane
    views         Cameras: how points are projected, and the presets that show a whole hall
    viser_compat  The private parts of viser that we use, all in one place; written for viser 1.1
    wheels        Wheels that roll: which joints, and how far each turns
    labels        Which labels are shown, and where, so that none covers another one

    scenery       The fixed scene, drawn once; and the walkers
    visuals       What the links of a URDF show: meshes in their colours, and spokes on plain wheels
    overlay       What one page shows of all robots: names and states, trails, committed motion
    robot_mesh    What a robot looks like: the visuals of its URDF as GLB, also without its wheels
    bodies        All robots of one model: in detail nearby, else in one colour
    robot_layers  What one page shows of its robot: scan, plans, claims, costmaps, goal
    fleet         All robots: batches per model, and a mark below each
    page_view     How one page looks at the scene: camera, walls, light or dark

May import of swarm_view: `state`.
"""

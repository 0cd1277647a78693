"""The operator's eyes: a live 3D view in the browser. Nobody imports this package.

What imports nothing of the rows below it stands first:

    state         What is known of the swarm, and where it comes from
    scene         What is drawn in 3D
    page          One browser page
    server        The door to the browser
    viewer        The loop: messages in, frames out
    process       The process that swarm-up starts
    view_command  The command `swarm-view`: its options
    replay_command  The command `swarm-replay`: a recorded run in the viewer, or on the ROS graph
    cli           The entry points of both
"""

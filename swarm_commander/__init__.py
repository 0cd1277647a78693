"""The operator: bring-up, missions, reports; imports swarm_run and what that may.

Lower folders never import higher ones; the lowest stands first:

    mission  Missions, and what takes robots through them
    viewers  Configurations of RViz and Foxglove, and their windows
    run      A run of `swarm-up`, from its checked options to report and exit code
    hosts    A swarm on several hosts: the line between them, and what each end does
    cli      The commands
"""

"""A swarm on several hosts: the line between them, and what each end does.

What a module imports of its folder stands above it:

    run_description  The run as the world's host describes it to the robots' hosts: robots and
                     all their parameters
    distributor      On a robots' host: gives each robot its part of the batch of beacons that
                     came from the world
    host_link        What both ends of the line between the world's host and a robots' host have
                     in common
    host_options     Options of a run on several hosts, checked once: --role, --robots,
                     --connect, --bind
    link_probe       Probes of the network between two hosts: packet sizes, directions, losses,
                     round trips
    host_table       The list of robots' hosts on the world's host: their robots, silences and
                     departures
    client_state     A robots' host towards the world's: its reports, and its reaction to the
                     answers
    host_door        Where messages of robots' hosts reach the world's host; only sealed ones
                     pass
    robots_plan      The checked input of `swarm-up --role robots`
    host_client      A robots' host towards the world's: a process of `swarm-up --role robots`
    host_server      The world's host towards the robots' hosts: a process of `swarm-up --role
                     world`
    robots_run       `swarm-up --role robots`: the navigators of some robots on this host, the
                     world on another
    world_run        `swarm-up --role world`: world and mission on this host, navigators on
                     others
    hosts_command    What `swarm-up --role` does beside a run on one host: profiles of DDS, and
                     the robots' side

May import of swarm_commander: `run`, `mission`, `viewers`; and swarm_common.
"""

"""A swarm on several hosts: the line between them, and what each end does.

What a module imports of its folder stands above it:

    run_description  The run as the world's host describes it to the robots' hosts
    distributor      On a robots' host: gives each robot its part of a batch of beacons
    host_link        What both ends of the line between two hosts have in common
    link_probe       Probes of the network: packet sizes, directions, losses, round trips
    host_table       The robots' hosts as the world's host knows them: robots, silences
    client_state     What a robots' host reports, and how it reacts to the answers
    robots_plan      The checked input of `swarm-up --role robots`
    host_client      A robots' host towards the world's: a process
    host_server      The world's host towards the robots' hosts: a process
    robots_run       `swarm-up --role robots`: navigators here, the world elsewhere
    hosted_navigators   Navigators of `swarm-up --role world`, which are on other hosts
    hosts_command    What `--role` does beside a run: DDS profiles, the robots' side

May import of swarm_commander: `run`, `mission`, `viewers`; swarm_run and swarm_common.
"""

"""A run of `swarm-up`, from its checked options to report and exit code.

What a module imports of its folder stands above it:

    wait_graph      Which robot waits for which, as the robots report, and circles of waiting that
                    last
    run_statistics  The state of a run while it goes on: events of the processes added up
    domain          One swarm per ROS domain, since two would have the same names; its owner takes
                    requests
    fairness        How evenly a swarm was served
    flat            Parameters under dotted names, as ROS 2 counts them, and nested, as files have
                    them
    heartbeat       Which processes have said nothing for too long. No I/O
    options         Options of `swarm-up`, checked once
    restarts        Decides when, and how often at most, a process that died is restarted. No clock,
                    no I/O
    rundir          The folder of a run: parameters, logs, report, and what another terminal must
                    source
    signals         Signals that ask for the end, counted
    supervisor      Table of the processes of a run: which run, which have ended, and the order of
                    stopping
    terminal        Output that may end before the run does: a pipe into `head`, a terminal that is
                    closed
    usage           CPU time and memory of the processes of a run
    keeper          Restarts navigators: which run, which are to be restarted, and whether the fork
                    server obeys
    launch          Starts a child process with its log and two pipes, so that it never outlives us
    world_params    The section `/world:` of a --params file: radio, engine, robots that are broken
    params          Parameter files of the navigators: defaults, the robot's data, the user's
                    overrides
    report          `report.json`: the result of a run in the form that tools outside rely on
    status_table    The robots in a few lines: a letter each, one line per group, however large the
                    swarm
    plan            Everything that is checked and loaded before a run starts a single process
    progress        What the user sees while a run goes, and the table at its end
    process_run     Processes of a run: started, listened to, and ended together
    recording       What swarm-up tells the recorder process, and where the bag goes
    local_run       A run from the first process to the report: what `swarm-up` does after its input
                    is checked

May import of swarm_commander: `mission`, `viewers`; and swarm_common.
"""

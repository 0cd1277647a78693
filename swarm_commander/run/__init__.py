"""A run of `swarm-up`, from its checked options to report and exit code.

What a module imports of its folder stands above it:

    processes    The processes of a run: started, watched, restarted, measured, ended
    rundir       The folder of a run: parameters, logs, report, and what another terminal must
                 source
    terminal     Output that may end before the run does: a pipe into `head`, a terminal that is
                 closed
    results      What a run comes to: numbers while it goes on, the terminal, and the report
    process_table   Processes of a run, one line each
    supervision  Processes of a run: started, listened to, and ended together
    fork_server  The fork server of this host, which starts navigators
    own_navigators  Navigators of a run on one host
    local_run    A run from the first process to the report: what `swarm-up` does after its input is
                 checked

May import of swarm_commander: `mission`, `viewers`; swarm_run and swarm_common.
"""

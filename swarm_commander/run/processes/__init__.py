"""The processes of a run: started, watched, restarted, measured, ended.

What a module imports of its folder stands above it:

    restarts    Which processes are silent, and when one that died is restarted. No I/O
    supervisor  Table of the processes of a run: which run, which have ended, and the order of
                stopping
    usage       CPU time and memory of the processes of a run
    navigators  Restarts navigators: which run, which are to be restarted, and whether the fork
                server obeys
    launch      Starts a child process with its log and two pipes, so that it never outlives us

May import what `run` may, but of `run` itself nothing.
"""

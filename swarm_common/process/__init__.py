"""Requests of processes to the kernel and to each other.

What a module imports of its folder stands above it:

    start           The start of our own processes, and of the user's browser
    compile_watch  Tells how far numba has compiled, so that a first start does not look like a hang
    home           Folders for files if there is no home folder, or a read-only one
    compiled_code  Source of the navigators' modules, and the edition of all code
    libm   exp, log and arctan2 of arrays, with the same last bits on every processor
    lifetime       Lifetime of processes: they end with their parent, and interrupt nobody
    messages       Messages between swarm-up and the processes that it starts
    numba_compat   The private part of numba that we use: compiled kernels are kept by content
    pipes          Pipes between swarm-up and its processes; one message per line
    plugins        Plug-ins of users, found by name and kept from harming anybody else
    private_parts  Parts of libraries that are private to them: one that moved is told
    signals        Signals that ask for the end: counted, or put off while a library is loaded
    quick_start    Quick start of a process, and of one that can fork: it has one thread
    standard_streams  stdin, stdout and stderr, whatever those that started us made of them

May import `model` of swarm_common.
"""

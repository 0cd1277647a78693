"""Other simulators on our workload; each module is a program for an environment that has its peer.

They import nothing of the project but `job.py`, and are run by `python -m benchmarks peers` only.
"""

"""Environments of others beside ours: robot-steps with a LiDAR scan each, per second of CPU time.

    drivers  One simulator, in an interpreter in which it is installed; imports nothing of ours
    command  `python -m benchmarks peers`: rounds of all of them in turns

Others are installed with `pip install navground vmas ir-sim` in an environment of their own.
"""

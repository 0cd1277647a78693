"""LiDARs, encoders and the radio.

What a module imports of its folder stands above it:

    drift           Uncertainty of a robot's odometry
    motion_sensors  Wheel encoders and IMUs of all robots: their readings of a motion, with errors
    radio_kernels   Numba kernels of the radio: who hears whom, and what they receive
    lidar_kernels   Numba kernels of the LiDAR: rays, segments, discs, noise
    radio           The radio: which robots hear which beacons at a tick, with range, loss and delay
    lidar           The LiDARs of all robots: their sections of the world, and scans

May import of swarm_sim: `physics`, `scene`; and lower packages.
"""

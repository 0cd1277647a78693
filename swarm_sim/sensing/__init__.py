"""LiDARs, encoders and the radio.

What a module imports of its folder stands above it:

    drift           How uncertain a robot's odometry is, by the error model that its readings are
                    drawn from
    motion_sensors  Wheel encoders and IMUs of all robots: their readings of a motion, with errors
    radio_kernels   Numba kernels of the radio: which robots hear each other, and the beacons each
                    receives
    lidar_kernels   Numba kernels of the LiDAR: rays against segments and discs in the plane, and
                    range noise
    radio           The radio: which robots hear which beacons at a tick, with range, loss and delay
    lidar           The LiDARs of all robots: the section of the world at each scan plane, and when
                    scans are due

May import of swarm_sim: `physics`, `sdf`, `scene`; and swarm_common.
"""

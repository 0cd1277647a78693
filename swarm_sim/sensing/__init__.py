"""LiDARs, encoders and the radio.

What a module imports of its folder stands above it:

    motion_sensors  Wheel encoders and IMUs of all robots: what they report of a motion, with
                    their errors
    radio_kernels   Numba kernels of the radio: who hears whom, and what each receiver hears
    lidar_kernels   Numba kernels of the LiDAR: rays against segments and discs in the plane,
                    and range noise
    radio           The radio: who hears whose beacon at a tick, with range, loss and delay
    lidar           The LiDARs of all robots: what is at the height of each scan plane, and when
                    scans are due

May import of swarm_sim: `physics`, `sdf`, `scene`; and swarm_common.
"""

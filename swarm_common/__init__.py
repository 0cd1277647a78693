"""Vocabulary shared by the world, the robots and the operator; may be imported by every package.

Lower folders never import higher ones; the lowest stands first:

    model       Values that all parties speak of
    process     Requests of processes to the kernel and to each other
    files       Files that are read and written: maps, sites, caches, the data that ships with the
                project
    middleware  ROS 2 and DDS as all processes use them

What holds for every function here, in `swarm_describe` and in `swarm_sim`, unless its docstring
says otherwise:

- Lengths are in metres, angles in radians, times in seconds, masses in kilograms.
- Places and poses (x, y, yaw) are in the map frame.
- `now` is wall time, `tick` the current control tick.
- `where` and `what` name the file and key, or the element, that a message is about.
- What cannot be used raises the `SwarmError` of its kind (`model/errors.py`); the message says what
  was found, where, and what to do. Requests of clients raise RefusedError, messages from the
  network RejectedError.
"""

from swarm_common.process.compiled_code import use_compiled

use_compiled()

"""The robot's end of Clearway's line for MicroPython boards: copy this folder to the board.

In the order of the data: ``link`` takes bytes and makes frames, ``robot`` decides, ``follower``
drives along the waypoints, ``estimate`` knows where the robot is, ``fixed`` computes; ``program``
runs them on a board's wheels and serial line. The twin of the C99 firmware, number for number.

Nothing here allocates while it runs: whole numbers stay below 2^30, which 32-bit boards keep
without the heap, larger ones are kept in halves of 16 bits, and results of more than one number
are left in arrays. The arithmetic also runs under CPython, where it is compared with the C twin.
"""

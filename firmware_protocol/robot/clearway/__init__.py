"""The robot's end of Clearway's line: copy this folder to a MicroPython board.

In the order of the data: ``link`` takes bytes and makes frames (``frames``, ``wire``), ``robot``
decides by the table of ``states``, ``follower`` drives along the waypoints of ``waypoints``,
``estimate`` knows where the robot is, ``pulses`` turns wheels more slowly than they can, ``fixed``
computes; ``program`` runs them on a board's wheels and serial line (``wheels``, ``lines``).

The same robot as the C99 firmware, number for number. Clearway's simulator and its drivers run it
under CPython, where the two are compared. So that nothing here allocates on a 32-bit board while
it runs: whole numbers stay below 2^30, larger ones are kept in halves of 16 bits, results of more
than one number are left in arrays, and no more than three names are assigned at once.
"""

"""The robot's end of Clearway's line: copy this folder to a MicroPython board.

In the order of the data: ``link`` takes bytes and makes frames (``frames``, ``wire``), ``robot``
decides by the table of ``states``, ``follower`` drives along the waypoints of ``waypoints``,
``estimate`` keeps the pose, ``pulses`` turns wheels below their least speed, ``fixed`` computes;
``program`` runs them on a board's wheels and serial line (``wheels``, ``lines``).

It equals the C99 firmware, number for number; simulator and drivers run it under CPython. Nothing
may allocate on a 32-bit board while it runs: whole numbers stay below 2^30, larger ones are kept in
halves of 16 bits, several results are left in arrays, and at most three names are assigned at once.
"""

"""Twins: robots that people own, as their vendors' documents describe them, on simulated wheels.

- `create2`, `turtlebot3`, `epuck2`, `waveshare`: one file a robot, sans-IO: the vendor's bytes in,
  the vendor's bytes and wheel speeds out, with its watchdog, its quirks and its update rate.
- `twin`: what all of them have in common; `kinds`: which there are, and what turns their wheels.
- `twin_robot`: one of them on a new pseudo-terminal or a serial port, in real time.

They are written from the vendors' documents alone and share no codec with `link.drivers`, so that
two readings of each document have to agree.
"""

"""Twins: robots for a simulated line, without the line and the floor.

- `twin`: the common face; `kinds`: twins by name, and their wheels.
- `clearway`: the robot with our own firmware.
- `create2`, `turtlebot3`, `epuck2`, `waveshare`: one file a robot, sans-IO: the vendor's bytes in,
  the vendor's bytes and wheel speeds out, with its watchdog, quirks and update rate.

The vendors' twins are written from the vendors' documents alone. They share no codec with
`link.drivers`, so two readings of each document must agree.
"""

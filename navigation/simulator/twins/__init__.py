"""Twins: the robots that can stand behind a simulated line, without line and floor.

- `clearway`: the robot with our own firmware; `emulated`: the same on an emulated processor.
- `create2`, `turtlebot3`, `epuck2`, `waveshare`: one file a robot, sans-IO: the vendor's bytes in,
  the vendor's bytes and wheel speeds out, with its watchdog, its quirks and its update rate.
- `twin`: what all of them have in common; `kinds`: which there are, and what turns their wheels.

Those of vendors are robots that people own, written from the vendors' documents alone. They share
no codec with `link.drivers`, so that two readings of each document have to agree.
"""

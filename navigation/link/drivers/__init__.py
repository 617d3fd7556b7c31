"""Robots that speak another protocol: each driver is the robot's end of our wire for one of them.

In the order of the data: `driver_link` is what the daemon talks to, `driver_process` starts the
process behind it, `serve` is its loop, in which `driven_robot` follows waypoints and `lent_port` is
the robot's line. The daemon has that line too: `robot_port` opens it, `driver_watch` misses the
process's heartbeat, and `robot_halt` then stops the robot itself until it is heard to stand.

- `robot_driver`: what a driver is; `wheel_odometry`, `standing`, `word_of_robot`: what they share.
- `create2`, `turtlebot3`, `epuck2`, `waveshare`: one file a robot, sans-IO.
- `drivers`: which there are; `recognise`: which of them answers on a port.

The process ends with the program that started it, and stops the robot first.
"""

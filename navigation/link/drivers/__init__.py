"""Robots that speak another protocol: each driver is the robot's end of our wire for one of them.

In the order of the data: `driver_link` is what the daemon talks to, `driver_process` starts and
watches the process behind it, `serve` is its loop, in which `driven_robot` follows waypoints and
`robot_port` opens the robot's line.

- `robot_driver`: what a driver is, and `wheel_odometry`, `word_of_robot` what they share.
- `create2`, `turtlebot3`, `epuck2`, `waveshare`: one file a robot, sans-IO.
- `drivers`: which there are; `recognise`: which of them answers on a port.

The process ends with the program that started it, and stops the robot first.
"""

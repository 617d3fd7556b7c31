"""Robots with another protocol: each driver is the robot's end of our wire for one of them.

In the order of the data: the daemon talks to `driver_link`; `driver_process` starts the process
behind it, whose loop is `serve`. In it `driven_robot` follows waypoints, and `lent_port` is the
robot's line. The daemon keeps that line too: `robot_port` opens it, `driver_watch` notices a missed
heartbeat of the process, and `robot_halt` then stops the robot until it reports rest.

- `robot_driver`: the protocol of a driver; `wheel_odometry`, `standing`, `word_of_robot`: shared.
- `create2` with `create2_wheel`, `turtlebot3`, `epuck2`, `waveshare`: the drivers, sans-IO.
- `drivers`: the list; `recognise`: finds the one that answers on a port.

The process ends with the program that started it, and stops the robot first.
"""

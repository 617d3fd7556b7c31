"""The simulated arena: its geometry, its camera and its robot.

- `settings` turns the configuration into the robot's settings.
- `arena` holds the obstacles; `happenings` changes them during a run; `picture/` shows them to the
  camera.
- `drive_model` moves wheels and odometry; `twins/` are the robots that order the wheels.
- `robot` puts a twin at the other end of a line in real time (`own_time`, `slowing_clock`);
  `line_faults` loses, damages and delays bytes.
- `virtual_loop` has both ends of the line and the robot in virtual time.
- `truth` and `shared_pose` give the true poses, for the camera and for measuring.
"""

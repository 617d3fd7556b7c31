"""The simulated arena: its geometry, its camera and its robot.

- `arena`: what stands in it; `happenings`: what changes while a run goes on; `settings`: all of it
  from the configuration.
- `picture`: what its camera sees.
- `drive_model`: wheels and odometry; `twins`: the robots that turn them; `robot`: one of these at
  the other end of a line, in real time (`own_time`); `emulated_processor`: what one of them runs
  on.
- `line_faults`: bytes that a line loses, damages and delays; `virtual_loop`: both ends of the line
  and the robot in virtual time; `virtual_robot`: that robot as the truth knows it.
- `truth`, `shared_pose`: where the robot really is, for the camera and for measuring.
"""

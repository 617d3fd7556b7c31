"""From a path to timed waypoints: rounded corners, stops, speeds.

- ``smooth.py`` rounds the path's corners and proves the clearance again (curves:
  ``smooth_kernels.py``).
- ``stops_and_bends.py`` cuts the path into legs at its stops and limits the speed along each.
- ``speed_profile.py`` plans the speed along one leg, with bounded jerk.
- ``trajectory.py`` combines these into timed waypoints.
"""

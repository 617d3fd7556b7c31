"""Several robots or cameras in one configuration.

- ``defaults.py`` treats the sections `robot`, `serial` and `camera` as defaults of the entries.
- ``each_robot.py`` and ``each_camera.py`` make one configuration for each robot or camera.
- ``fleet_checks.py`` and ``camera_checks.py`` check that the entries fit together: names, markers,
  ports, starts and goals of robots, sources and calibrations of cameras.
"""

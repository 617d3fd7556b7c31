"""Several robots or cameras in one configuration.

- `defaults` treats the sections `robot`, `serial` and `camera` as defaults of the entries.
- `each_robot` and `each_camera` make one configuration for each.
- `fleet_checks` and `camera_checks` check that the entries fit together.
"""

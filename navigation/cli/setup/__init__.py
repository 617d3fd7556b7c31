"""Commands that set up a machine and an arena.

- ``sample.py`` and ``init_config.py`` write a sample and a first configuration (its numbers come
  from ``starter_values.py``); ``schema.py`` describes the keys.
- ``devices.py`` lists ports and cameras; ``camera.py`` judges a camera by ``camera_watch.py``.
- ``marker.py`` prints markers and boards; ``calibrate.py`` calibrates a camera, ``reanchor.py``
  places a moved one again.
- ``check.py`` checks a configuration, ``doctor.py`` the machine.
- ``install_service.py`` installs a service; ``completion.py`` prints a shell's completion.
"""

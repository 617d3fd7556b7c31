"""Commands that drive, or talk to programs that do.

- ``run.py`` runs the daemon on a configuration; ``orders.py`` sends it orders,
  ``zones.py`` those that change zones.
- ``demo.py`` is a simulated run without any file; ``robot.py`` is a simulated robot on a port.
- ``dashboard.py`` shows a recording on the page, ``replay.py`` repeats vision and planning on one.
- ``sweep.py`` repeats a simulated run with other seeds and errors.
"""

"""Messages to the page: states, geometry, pictures, the log and the charts.

- ``state_message.py``: the greeting and the state, as JSON.
- ``geometry.py``: the scene, its diagram and the plans; ``heat.py``: every place's clearance.
- ``zones.py``: the zones, as a configuration has them.
- ``picture.py``: the camera's picture seen from above; ``camera_view.py``: unwarped, with the
  markers and borders found in it.
- ``packed.py``: arrays in one binary message with a JSON head.
- ``chronicle.py``: log, track and charts, kept in the rings of ``rings.py``.
- ``palette.py``: the pictures' colours as the page's style.
"""

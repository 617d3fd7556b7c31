"""Messages to the page: states, geometry, pictures, the log and the charts.

- `state_message`: the greeting and the state.
- `geometry`: the scene, its diagram and the plans; `heat`: every place's clearance; `zones`.
- `picture`: the camera's picture seen from above; `camera_view`: unwarped.
- `packed`: arrays in one binary message with a JSON head.
- `chronicle`: log, track and charts, kept in `rings`.
- `palette`: the pictures' colours as the page's style.
"""

"""``clearway calibrate --live``: the camera, and its display in a terminal and on a page.

- `command`: from the options to the views, and the sentence at the end.
- `live`: the camera; `vision.calibrate.live` takes the views.
- `terminal`: a table in a terminal, lines elsewhere.
- `page`: the dashboard's calibration panel alone in a browser, which only looks.
- `chosen_lens`: the lens from the views.

All displays take their sentences from `navigation.dashboard.calibrating`.
"""

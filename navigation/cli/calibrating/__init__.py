"""``clearway calibrate --live``: the camera, and its display in a terminal or on a page.

- `command`: from the options to the views, and the sentence at the end.
- `live`: the camera; `vision.calibrate.live` takes the views.
- `terminal`: a table in a terminal, lines elsewhere.
- `page`, `static/`: the same in a browser, with the picture.
- `chosen_lens`: the lens from the views.

Both displays take their sentences from `navigation.dashboard.calibrating`, whose page shows them,
too.
"""

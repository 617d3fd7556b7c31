"""``clearway calibrate --live``: the camera, what is shown of it, and where.

- `live`: the camera; `vision.calibrate.live` takes the views.
- `terminal`: a table in a terminal, lines where there is none.
- `page`, `static/`: the same in a browser, with the picture.

The sentences that both show are in `navigation.dashboard.calibrating`, whose page shows them, too.
"""

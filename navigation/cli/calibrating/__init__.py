"""``clearway calibrate --live``: the camera, what is shown of it, and where.

- `live`: the loop from the camera to the session (`vision.calibrate.live`) and to its viewers.
- `terminal`: a table in a terminal, lines where there is none.
- `page`, `static/`: the same in a browser, with the picture.
- `said`: the sentences that both show.
"""

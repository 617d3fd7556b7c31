"""Lens calibration from the run's page: the camera is lent, and the robot holds meanwhile.

- `bench`: from the start to a saved lens, or to a cancel; its thread.
- `frames`: the run's own pictures as a camera.
- `routes`: the addresses.
- `shown`, `said`: a live calibration as JSON, as a picture and in sentences.

`clearway calibrate --live` shows the same panel alone (`static/calibration.html` and its module),
from the addresses that only look.
"""

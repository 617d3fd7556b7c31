"""The lens calibrated from the run's page: the camera is lent, and the robot holds meanwhile.

- `bench`: from the start to a lens that is saved, or to a cancel; its thread.
- `frames`: the run's own pictures as a camera.
- `routes`: the addresses.
- `shown`, `said`: a live calibration as JSON, as a picture and in sentences, as `clearway calibrate
  --live` shows it, too.
"""

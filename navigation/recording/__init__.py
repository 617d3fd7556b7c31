"""Recordings of runs: events into MCAP files, and back.

- `events` are made in the loops; `json_bodies` and `foxglove` give them their forms in the file,
  the second for any MCAP viewer, with `border_points` for a scene; `zone_bodies` is for zones.
- `files` writes them, starts a new file when one is full, and `standing` repeats at its beginning
  what is still valid; `names` is how files are called.
- `messages` and `reader` read a file within bounds, even one cut off by a kill.
- `tape` is the recording at any moment, and `compare` says how far a replay differs from it.
"""

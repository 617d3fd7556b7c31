"""Recordings of runs: events into MCAP files, and back.

- `events` are made in the loops; `json_bodies`, `zone_bodies` and, for any MCAP viewer, `foxglove`
  give them their forms in the file; `border_points` makes lines of a scene.
- `files` writes them, and starts a new file when one is full, with what still holds (`standing`);
  `names` is how files are called.
- `messages` and `reader` read a file within bounds, even one cut off by a kill.
- `tape` is the recording at any moment; `compare` measures how far a replay differs from it.
"""

"""Recordings of runs: events into MCAP files, and back.

- `events` are made in the loops; `json_bodies`, `zone_bodies` and, for any MCAP viewer, `foxglove`
  give them their forms in the file.
- `files` writes them, and starts a new file when one is full, with what still holds (`standing`).
- `messages` and `reader` read a file within bounds, even one cut off by a kill; `live_bodies` is
  what a page is shown of links and waiting robots.
- `tape` is the recording at any moment; `compare` measures how far a replay differs from it.
"""

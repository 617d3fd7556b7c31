"""Missions, stops and zones on disk, so that a restarted run continues where it ended.

- `journal`: the mission, its progress and the robot's plan, read at the start and written on
  change.
- `journal_records`: these as text.
- `journal_file`: the sealed file of that text, written whole and used by one program.
- `stop_latch`: each stop as a file, in force until a person re-arms.
- `kept_stops`: the stops of a run: written before they are confirmed, removed by a re-arm only.
- `kept_zones`: the zones that people changed, with which the next run begins.
"""

"""Missions, stops and zones on disk, so that a restarted run continues where it ended.

- `journal`: the mission, its progress and the robot's plan; `journal_records`: these as text;
  `journal_file`: that text's sealed file; `journal_lock`: what keeps a second program from it.
- `stop_latch`: each stop as a file; `kept_stops`: those of a run.
- `kept_zones`: the zones that people changed, with which the next run begins; `zones_writer`: the
  thread that writes them.
"""

"""A recording on the page, with the same messages as a run.

- `player`: the place in the recording, playing or paused, and the speed.
- `taped_robot`: one robot of the recording at any moment; `replayed_run`: all of it at the player's
  moment, as a daemon would publish it; `replay_hub`: its page's hub.

Nothing here has a camera, a robot or a port.
"""

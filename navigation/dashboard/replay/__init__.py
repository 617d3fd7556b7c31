"""A recording on the page, with the same messages as a run.

- `player`: the place in the recording, playing or paused, and the speed.
- `taped_robot`: one robot of the recording at any moment; `replayed_run`: the recording at the
  player's moment, as a daemon would publish it.
- `replay_hub`: the hub of such a page.

Nothing here has a camera, a robot or a port: every order is refused.
"""

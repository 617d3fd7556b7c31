"""A recording on the page: the same page and messages, made from the recording.

- `player`: the place in the recording, playing or paused, and the speed.
- `taped_robot`: one robot of the recording at any moment; `replayed_run`: the recording at the
  player's moment, as a daemon of one robot or several would publish it.
- `replay_hub`: the hub of such a page; it can be steered and begins again after a jump.

Nothing here has a camera, a robot or a port: every order is refused with a sentence.
"""

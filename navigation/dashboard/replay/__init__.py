"""A recording on the page: the same page and the same messages, made of what was recorded.

- `player`: where in the recording one is: playing, paused, how fast.
- `taped_robot`: one robot of the recording at any moment; `replayed_run`: the recording at the
  player's moment, as a daemon of one robot or of several would publish it; it takes no orders.
- `replay_hub`: the hub of such a page, which can be steered and begins again where one jumps.

Nothing here has a camera, a robot or a port: whatever is ordered is refused with a sentence.
"""

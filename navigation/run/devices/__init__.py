"""Cameras and robots as a run opens them.

- `cameras`: the cameras of a configuration, one or several as one; `device_settings` is what a run
  asks of a plugged-in camera.
- `driven`: robots with another maker's protocol, through their driver.
- `simulated`: the simulated robot, and where the simulated camera sees it.
- `world_clock` and `wakeups`: the clock of the run, and how late its threads are woken.
"""

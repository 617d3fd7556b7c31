"""Cameras and robots as a run opens them.

- `cameras`: the configured ones, one or several as one; `device_settings` of a plugged-in one.
- `driven`: robots with another protocol, through their driver.
- `simulated`: the simulated robot and its pose for the simulated camera.
- `world_clock` and `wakeups`: the clock of the run, and the delay in waking its threads.
"""
